/**
 * What happens in the repository while one looks. One stream for all tabs: HTTP/1.1 allows six connections a host, and
 * open tabs would eat them. The tab that holds the lock listens, and tells the others.
 */
import { signal } from "@preact/signals";

/** Data of events `document` and `label`; schemas/events.py. Streams have no types in the description. */
export interface News {
  document: string;
  revision: number;
  operation: string;
  name: string;
  project: string;
  author: string;
  time: string;
}

/** The newest thing that was heard. */
export const news = signal<News | null>(null);

export function followEvents(): void {
  const channel = "BroadcastChannel" in window ? new BroadcastChannel("mcml.events") : null;
  if (channel) channel.onmessage = (event: MessageEvent<News>) => (news.value = event.data);
  const listen = () => {
    const source = new EventSource("/api/v1/events");
    const heard = (event: MessageEvent<string>) => {
      const one = JSON.parse(event.data) as News;
      news.value = one;
      channel?.postMessage(one);
    };
    for (const kind of ["document", "label"]) source.addEventListener(kind, heard as EventListener);
  };
  // Held for as long as this tab lives.
  if (navigator.locks) void navigator.locks.request("mcml.events", () => (listen(), new Promise<never>(() => undefined)));
  else listen();
}
