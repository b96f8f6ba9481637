// @vitest-environment happy-dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { commented, followEvents, news } from "./events";

class Stream extends EventTarget {
  static readonly CLOSED = 2;
  static all: Stream[] = [];
  readyState = 1;
  onerror: () => void = () => undefined;
  constructor(readonly url: string) {
    super();
    Stream.all.push(this);
  }
  tell(kind: string, id: string, data: unknown = null): void {
    this.dispatchEvent(new MessageEvent(kind, { lastEventId: id, data: JSON.stringify(data) }));
  }
}
class Channel {
  static open: Channel | null = null;
  onmessage: ((event: MessageEvent) => void) | null = null;
  sent: unknown[] = [];
  constructor() {
    Channel.open = this;
  }
  postMessage(what: unknown): void {
    this.sent.push(what);
  }
}

beforeEach(() => {
  vi.useFakeTimers();
  Stream.all = [];
  vi.stubGlobal("EventSource", Stream);
  vi.stubGlobal("BroadcastChannel", Channel);
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const listening = (hasLock: boolean) => {
  vi.stubGlobal("navigator", { locks: { request: (_: string, run: () => unknown) => (hasLock ? run() : undefined) } });
  followEvents();
};

it("the tab with the lock hears, and tells the others", () => {
  listening(true);
  Stream.all[0]!.tell("document", "5", { document: "a" });
  Stream.all[0]!.tell("comment", "6", { id: 1, document: "a" });
  expect([news.value?.document, commented.value?.id]).toEqual(["a", 1]);
  expect(Channel.open?.sent).toEqual([{ news: { document: "a" } }, { commented: { id: 1, document: "a" } }]);
});

it("a tab without it asks for no stream, and hears from the other", () => {
  listening(false);
  expect(Stream.all).toEqual([]);
  Channel.open?.onmessage?.(new MessageEvent("message", { data: { news: { document: "b" } } }));
  expect(news.value?.document).toBe("b");
  expect(Channel.open?.sent).toEqual([]);
});

it("a stream that was refused is asked for again from the last event on; one that the browser mends is not", () => {
  listening(true);
  const [first] = Stream.all;
  first!.tell("ready", "7 8");
  first!.onerror();
  vi.advanceTimersByTime(60_000);
  expect(Stream.all.length).toBe(1);
  first!.readyState = Stream.CLOSED;
  first!.onerror();
  vi.advanceTimersByTime(29_000);
  expect(Stream.all.length).toBe(1);
  vi.advanceTimersByTime(1000);
  expect(Stream.all.map((one) => one.url)).toEqual(["/api/v1/events", "/api/v1/events?since=7%208"]);
});
