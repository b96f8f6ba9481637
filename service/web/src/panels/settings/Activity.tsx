/** What was done, by whom and when: the newest first, heard while one looks. */
import { useEffect, useRef, useState } from "preact/hooks";
import { get, type Schemas } from "../../api/client";
import { commented, news } from "../../state/session/events";
import { param, setParams } from "../../state/session/route";
import { language } from "../../state/session/settings";
import { Icon } from "../../ui/icons";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import { day } from "./tables";
import { s } from "./words";

type Event = Schemas["ActivityEvent"];
/** What events are about. */
export const KINDS = [
  "document",
  "comment",
  "project",
  "job",
  "member",
  "share",
  "webhook",
  "account",
  "token",
] as const;
const SPANS = [1, 7, 30] as const; // days
const PAGE = 50;
const BURST = 400; // ms: several things done at once are asked for once

/** What the address asks for; `since` counts back from when it was chosen. */
function wanted() {
  const days = Number(param("days"));
  const since = days > 0 ? `${new Date(Date.now() - days * 86_400_000).toISOString().slice(0, 19)}Z` : undefined;
  const kind = KINDS.find((one) => one === param("kind"));
  return {
    author: param("author") || undefined,
    project: param("project") || undefined,
    document: param("document") || undefined,
    kind,
    since,
  };
}

export function Activity() {
  const [items, setItems] = useState<Event[] | null>(null);
  const [cursor, setCursor] = useState<string | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  const key = JSON.stringify(["author", "project", "document", "kind", "days"].map(param));
  const asked = useRef(key);
  asked.current = key;
  const page = async (after: string | null) => {
    setBusy(true);
    try {
      const found = await get("/activity", { query: { ...wanted(), limit: PAGE, cursor: after ?? undefined } });
      if (asked.current !== key) return;
      setItems((before) => (after ? [...(before ?? []), ...found.items] : found.items));
      setCursor(found.next_cursor ?? null);
      setError(null);
    } catch (problem) {
      if (asked.current === key) setError(problem);
    } finally {
      setBusy(false);
    }
  };
  /** What came since; where that is more than a page, the list begins anew. */
  const look = async () => {
    try {
      const found = await get("/activity", { query: { ...wanted(), limit: PAGE } });
      if (asked.current !== key) return;
      setItems((before) => {
        const newest = before?.[0]?.id ?? 0;
        const fresh = found.items.filter((one) => one.id > newest);
        if (fresh.length < found.items.length || !found.next_cursor) return [...fresh, ...(before ?? [])];
        setCursor(found.next_cursor);
        return found.items;
      });
    } catch {
      /* What is shown stays; the strip of the connection says the rest. */
    }
  };
  useEffect(() => {
    setItems(null);
    void page(null);
    let timer = 0;
    const soon = () => {
      window.clearTimeout(timer);
      timer = window.setTimeout(() => void look(), BURST);
    };
    // The feed tells of clips and comments; what else was done is seen when one comes back to the page.
    const shown = () => document.visibilityState === "visible" && soon();
    let first = true;
    const heard = () => void (first || soon());
    const stops = [news.subscribe(heard), commented.subscribe(heard)];
    first = false;
    document.addEventListener("visibilitychange", shown);
    return () => {
      window.clearTimeout(timer);
      stops.forEach((stop) => stop());
      document.removeEventListener("visibilitychange", shown);
    };
  }, [key]);
  const set = (name: string, value: string) => setParams({ [name]: value || null }, true);
  const people = [...new Set((items ?? []).map((one) => one.author))].sort();
  const filtered = JSON.parse(key).some(Boolean) as boolean;
  return (
    <>
      <p class="row wrap activity-filters" role="search">
        <input
          class="field"
          list="activity-people"
          key={param("author")}
          aria-label={s("label.person")}
          placeholder={s("label.anybody")}
          defaultValue={param("author")}
          onChange={(event) => set("author", event.currentTarget.value.trim())}
        />
        <datalist id="activity-people">
          {people.map((one) => (
            <option key={one} value={one} />
          ))}
        </datalist>
        <select
          class="field"
          aria-label={s("label.kind")}
          value={param("kind")}
          onChange={(event) => set("kind", event.currentTarget.value)}
        >
          <option value="">{s("label.anyKind")}</option>
          {KINDS.map((one) => (
            <option key={one} value={one}>
              {s(`label.kind_${one}`)}
            </option>
          ))}
        </select>
        <select
          class="field"
          aria-label={w("label.project")}
          value={param("project")}
          onChange={(event) => set("project", event.currentTarget.value)}
        >
          <option value="">{w("label.allProjects")}</option>
          {projects.value?.items.map((one) => (
            <option key={one}>{one}</option>
          ))}
        </select>
        <select
          class="field"
          aria-label={s("label.span")}
          value={param("days")}
          onChange={(event) => set("days", event.currentTarget.value)}
        >
          <option value="">{s("label.anyTime")}</option>
          {SPANS.map((one) => (
            <option key={one} value={one}>
              {s("label.lastDays", { n: one })}
            </option>
          ))}
        </select>
        {param("document") && (
          <button type="button" class="chip" onClick={() => set("document", "")}>
            {s("label.oneClip")}
            <Icon name="close" />
          </button>
        )}
      </p>
      <Trouble error={error} retry={() => void page(cursor && items ? cursor : null)} />
      {items?.length === 0 && <p class="dim">{s(filtered ? "help.nothingSo" : "help.nothingDone")}</p>}
      {items && <Days items={items} />}
      {cursor && (
        <p>
          <button type="button" class="button" disabled={busy} onClick={() => void page(cursor)}>
            {w("label.more")}
          </button>
        </p>
      )}
    </>
  );
}

function Days({ items }: { items: Event[] }) {
  const days = new Map<string, Event[]>();
  for (const one of items) days.set(day(one.time), [...(days.get(day(one.time)) ?? []), one]);
  return (
    <>
      {[...days].map(([date, some]) => (
        <section key={date}>
          <h3>{date}</h3>
          <ol class="activity">
            {some.map((one) => (
              <Row key={one.id} event={one} />
            ))}
          </ol>
        </section>
      ))}
    </>
  );
}

function Row({ event }: { event: Event }) {
  const at = new Date(event.time);
  const word = `label.did_${event.kind}_${event.what}`;
  const did = word in s.en ? s(word as keyof typeof s.en) : `${s(`label.kind_${event.kind}`)}: ${event.what}`;
  return (
    <li>
      <time class="dim" dateTime={event.time} title={at.toLocaleString(language.value)}>
        {at.toLocaleTimeString(language.value, { hour: "2-digit", minute: "2-digit", hourCycle: "h23" })}
      </time>
      <span class="cut" title={event.origin ? s("label.from", { origin: event.origin }) : undefined}>
        {event.author}
      </span>
      {/* Only English says what was done before what it was done to. */}
      <span class="activity-what">
        {language.value === "en" ? (
          <>
            {did} <About event={event} />
          </>
        ) : (
          <>
            <About event={event} /> {did}
          </>
        )}
      </span>
      <span class="dim cut">{event.kind === "project" ? "" : event.project}</span>
    </li>
  );
}

/** What it was done to: a way to the clip as it was then, where it is there. */
function About({ event }: { event: Event }) {
  const { document: id, name, revision, kind, what, subject } = event;
  if (!id) return <>{kind === "project" ? (event.project ?? subject) : subject}</>;
  if (!name || what === "purge") return <span class="dim">{s("label.goneClip")}</span>;
  if (kind === "document" && what === "delete") return <>{name}</>;
  const view = kind === "comment" ? "?tab=comments" : revision ? `?rev=${revision}` : "";
  return (
    <>
      <a href={`/clips/${id}${view}`}>{name}</a>
      {revision !== null && kind === "document" && <span class="dim"> {w("label.revision", { n: revision })}</span>}
    </>
  );
}
