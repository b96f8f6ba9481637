/** The clips that an analysis reads: by project, motion name, property or XPath, or those picked in the library. */
import { useEffect, useState } from "preact/hooks";
import { get } from "../../api/client";
import { fromBase64, readThumbnail, type Thumbnail } from "../../motion/loading/thumbnail";
import { picked } from "../../state/library/library";
import { param, route, setParams } from "../../state/session/route";
import { duration, w } from "../../words";
import { ThumbnailView } from "./ThumbnailView";
import { Trouble } from "../Trouble";
import { useAsync } from "../useAsync";

export interface Selection {
  documents?: string[];
  project?: string;
  motion_name?: string;
  property?: string[];
  xpath?: string;
}
export interface Member {
  id: string;
  name: string;
  time: string;
  project: string;
  thumb: Thumbnail | null;
}

const MOST = 2000;
const PAGE = 200;
const AT_ONCE = 6; // requests
const FIELDS = ["project", "motion_name", "property", "xpath"] as const;

/** What the address says is selected; null: nothing yet. */
export function selectionNow(): Selection | null {
  const documents = route.value.params.getAll("doc");
  if (documents.length) return { documents };
  const found: Selection = {};
  for (const name of FIELDS) {
    const value = param(name);
    if (value && name === "property") found.property = [value];
    else if (value) found[name as "project"] = value;
  }
  return Object.keys(found).length ? found : null;
}

/** The clips of a selection, with their moving pictures. */
export function useMembers(selection: Selection | null): ReturnType<typeof useAsync<Member[]>> {
  return useAsync(
    async (signal) => {
      if (!selection) return [];
      const found: Member[] = [];
      const own = selection.documents ?? [];
      for (let at = 0; at < own.length; at += AT_ONCE)
        found.push(
          ...(await Promise.all(
            own.slice(at, at + AT_ONCE).map(async (id) => {
              const one = await get("/documents/{id}", { path: { id }, signal });
              return { id, name: one.name, time: duration(one.duration), project: one.project, thumb: null };
            }),
          )),
        );
      if (own.length) return found;
      for (let offset = 0; offset < MOST; offset += PAGE) {
        const page = await get("/documents", {
          query: { ...selection, limit: PAGE, offset, sort: "name", with: "thumbnail" } as never,
          signal,
        });
        found.push(
          ...page.items.map((one) => ({
            id: one.id,
            name: one.name,
            time: duration(one.duration),
            project: one.project,
            thumb: one.thumbnail ? readThumbnail(fromBase64(one.thumbnail)) : null,
          })),
        );
        if (page.items.length < PAGE) break;
      }
      return found;
    },
    [JSON.stringify(selection)],
  );
}

/** Fields for the selection in the address, and its clips. left: ids that are not to be read; onLeft: with all of them. */
export function ClipSelection({
  members,
  left,
  onLeft,
}: {
  members: ReturnType<typeof useMembers>;
  left?: ReadonlySet<string>;
  onLeft?: (left: ReadonlySet<string>) => void;
}) {
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  const [hovered, setHovered] = useState("");
  const own = route.value.params.getAll("doc");
  const write = (name: string, value: string) => setParams({ [name]: value || null });
  const takePicked = () => {
    const params = new URLSearchParams(route.peek().params);
    for (const name of [...FIELDS, "doc"]) params.delete(name);
    for (const id of picked.peek()) params.append("doc", id);
    setParams({ project: null, motion_name: null, property: null, xpath: null });
    history.replaceState(null, "", `${location.pathname}?${params}`);
    route.value = { ...route.peek(), params };
  };
  return (
    <div class="clip-selection">
      {own.length ? (
        <div class="row">
          <strong class="grow">{w("label.clips", { n: own.length })}</strong>
          <button
            type="button"
            class="button dense"
            onClick={() => {
              const params = new URLSearchParams(route.peek().params);
              params.delete("doc");
              route.value = { ...route.peek(), params };
              history.replaceState(null, "", `${location.pathname}?${params}`);
            }}
          >
            {w("button.chooseOthers")}
          </button>
        </div>
      ) : (
        <div class="selection-fields">
          <label>
            {w("label.project")}
            <select
              class="field"
              value={param("project")}
              onChange={(event) => write("project", event.currentTarget.value)}
            >
              <option value="">–</option>
              {(projects.value?.items ?? []).map((one) => (
                <option key={one} value={one}>
                  {one}
                </option>
              ))}
            </select>
          </label>
          <Late label={w("label.motionName")} name="motion_name" onWrite={write} />
          <Late label={w("label.propertyField")} name="property" hint="age:20..30" onWrite={write} />
          <Late label="XPath" name="xpath" hint="//frame[motion_name = 'walk']" onWrite={write} />
        </div>
      )}
      {picked.value.size > 0 && !own.length && (
        <button type="button" class="button dense" onClick={takePicked}>
          {w("button.usePicked", { n: picked.value.size })}
        </button>
      )}
      <Trouble error={members.error} retry={members.again} />
      {members.busy && <div class="busy" />}
      {members.value && members.value.length > 0 && (
        <p class="dim">{w("label.clips", { n: members.value.length - (left?.size ?? 0) })}</p>
      )}
      <ul class="selection-list">
        {(members.value ?? []).slice(0, PAGE).map((one) => (
          <li key={one.id} class={left?.has(one.id) ? "left-out" : ""} onPointerEnter={() => setHovered(one.id)}>
            {onLeft && (
              <input
                type="checkbox"
                aria-label={one.name}
                checked={!left?.has(one.id)}
                onChange={(event) => {
                  const others = [...(left ?? [])].filter((id) => id !== one.id);
                  onLeft(new Set(event.currentTarget.checked ? others : [...others, one.id]));
                }}
              />
            )}
            {one.thumb && <ThumbnailView thumbnail={one.thumb} runs={hovered === one.id} label="" />}
            <a class="cut grow" href={`/clips/${one.id}`}>
              {one.name}
            </a>
            <span class="dim">{one.time}</span>
          </li>
        ))}
      </ul>
    </div>
  );
}

const WAIT = 400; // ms of rest before what is written is asked

/** A field of the address, written when the hand rests. */
function Late({
  label,
  name,
  hint = "",
  onWrite,
}: {
  label: string;
  name: string;
  hint?: string;
  onWrite: (name: string, value: string) => void;
}) {
  const [text, setText] = useState(param(name));
  useEffect(() => {
    if (text === param(name)) return;
    const timer = setTimeout(() => onWrite(name, text), WAIT);
    return () => clearTimeout(timer);
  }, [text]);
  return (
    <label>
      {label}
      <input class="field" value={text} placeholder={hint} onInput={(event) => setText(event.currentTarget.value)} />
    </label>
  );
}
