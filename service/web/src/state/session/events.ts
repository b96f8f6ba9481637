/**
 * What happens in the repository while one looks. One stream for all tabs: HTTP/1.1 allows six connections a host, and
 * open tabs would eat them. The tab that holds the lock listens, and tells the others.
 */
import { signal } from "@preact/signals";

/** Data of events `document` and `label`; schemas/mcml_schemas/events.py. Streams have no types in the description. */
export interface News {
  document: string;
  revision: number;
  operation: string;
  name: string;
  project: string;
  author: string;
  time: string;
}

/** What was done with a comment or a proposal: the part of these events that is looked at; schemas/mcml_schemas/activity.py. */
export interface Commented {
  id: number;
  document: string | null;
}

/** The newest thing that was heard, and the newest of comments and of proposals. */
export const news = signal<News | null>(null);
export const commented = signal<Commented | null>(null);
export const proposed = signal<Commented | null>(null);

type Heard = { news: News } | { commented: Commented } | { proposed: Commented };
const tell = (heard: Heard): void => {
  if ("news" in heard) news.value = heard.news;
  else if ("commented" in heard) commented.value = heard.commented;
  else proposed.value = heard.proposed;
};

/** After so long a stream that was refused is asked for again. */
const AGAIN = 30_000;

export function followEvents(): void {
  const channel = "BroadcastChannel" in window ? new BroadcastChannel("mcml.events") : null;
  if (channel) channel.onmessage = (event: MessageEvent<Heard>) => tell(event.data);
  let last = "";
  const listen = () => {
    const source = new EventSource(`/api/v1/events${last && `?since=${encodeURIComponent(last)}`}`);
    const hear = (kind: string, as: "news" | "commented" | "proposed") =>
      source.addEventListener(kind, ((event: MessageEvent<string>) => {
        last = event.lastEventId;
        const heard = { [as]: JSON.parse(event.data) as unknown } as Heard;
        tell(heard);
        channel?.postMessage(heard);
      }) as EventListener);
    hear("document", "news");
    hear("label", "news");
    hear("comment", "commented");
    hear("proposal", "proposed");
    source.addEventListener("ready", ((event: MessageEvent<string>) => {
      last = event.lastEventId;
    }) as EventListener);
    // A stream that ends is asked for again by the browser; one that was refused is not, as while a server starts again.
    source.onerror = () => {
      if (source.readyState === EventSource.CLOSED) setTimeout(listen, AGAIN);
    };
  };
  // Held for as long as this tab lives.
  if (navigator.locks)
    void navigator.locks.request("mcml.events", () => (listen(), new Promise<never>(() => undefined)));
  else listen();
}
