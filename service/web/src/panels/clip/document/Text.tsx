/** MCML as text, a window of frames at a time: completion and checks by the DTD, real line numbers. */
import { itemAt } from "../../../lists";
import { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { xml, type ElementSpec } from "@codemirror/lang-xml";
import { foldGutter, HighlightStyle, syntaxHighlighting } from "@codemirror/language";
import { lintGutter, setDiagnostics, type Diagnostic } from "@codemirror/lint";
import { EditorState } from "@codemirror/state";
import { EditorView, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { useEffect, useRef, useState } from "preact/hooks";
import { ask, get } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { asChanges, withFragment, withSamples, orReplaced } from "../../../state/editing/draft";
import {
  changedFrames,
  changedParts,
  changedSamples,
  FRAMES_AT_ONCE,
  readWindow,
  type Replacement,
  type Window,
} from "../../../state/editing/lines";
import { note, refuse } from "../../../state/session/notes";
import { Icon } from "../../../ui/icons";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { theDtd } from "./AddElement";
import { number, w } from "../../../words";
import { completions } from "../../../state/editing/dtd";
import { editorTheme } from "../../../ui/editorTheme";

const colours = HighlightStyle.define([
  { tag: tags.tagName, color: "var(--left)" },
  { tag: tags.attributeName, color: "var(--accent)" },
  { tag: tags.attributeValue, color: "var(--text)" },
  { tag: [tags.angleBracket, tags.definitionOperator], color: "var(--text3)" },
  { tag: tags.comment, color: "var(--text3)" },
]);

export function TextView({ clip }: { clip: Clip; reload: () => void }) {
  const [frames, setFrames] = useState<[number, number] | null>(() => windowAt(clip, clip.player.frame.peek() + 1));
  const [search, setSearch] = useState("");
  const found = useAsync(
    (signal) => readWindow(clip.id, clip.detail.revision, frames, signal),
    [clip, frames?.[0], frames?.[1]],
  );
  const dtd = useAsync(async () => completions(await theDtd()), []);
  const move = (by: number) => {
    if (by < 0 && (!frames || frames[0] === 1)) {
      setFrames(null);
      return;
    }
    setFrames(windowAt(clip, frames ? frames[0] + by * FRAMES_AT_ONCE : 1));
  };
  const find = async () => {
    if (!search) return;
    try {
      const here = found.value ? found.value.firstLine + found.value.text.split("\n").length : 1;
      const answer =
        (
          await get("/documents/{id}/find", {
            path: { id: clip.id },
            query: { text: search, from: here, revision: clip.detail.revision },
          })
        ).place ?? null;
      if (!answer) {
        note(w("help.nothingFound"));
        return;
      }
      const frame = /frame\[(\d+)\]/.exec(answer.address);
      setFrames(frame ? windowAt(clip, Number(frame[1])) : null);
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <div class="text-view">
      <div class="row wrap text-tools">
        <button type="button" class="button quiet dense" aria-pressed={!frames} onClick={() => setFrames(null)}>
          {w("label.head")}
        </button>
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("label.backFrame")}
          disabled={!frames}
          onClick={() => move(-1)}
        >
          <Icon name="back" />
        </button>
        <button
          type="button"
          class="button quiet dense"
          onClick={() => setFrames(windowAt(clip, clip.player.frame.peek() + 1))}
        >
          {frames ? w("label.framesOf", { first: frames[0], last: frames[1] }) : w("label.frame")}
        </button>
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("label.nextFrame")}
          disabled={Boolean(frames && frames[1] >= clip.frames)}
          onClick={() => move(1)}
        >
          <Icon name="next" />
        </button>
        <span class="grow" />
        <input
          class="field dense-field"
          type="search"
          aria-label={w("label.search")}
          placeholder={w("label.search")}
          value={search}
          onInput={(event) => setSearch(event.currentTarget.value)}
          onKeyDown={(event) => {
            if (event.key === "Enter") void find();
          }}
        />
      </div>
      <Trouble error={found.error} retry={found.again} />
      {found.busy && <div class="busy" />}
      {found.value && dtd.value && (
        <Editor
          key={`${found.value.firstLine} ${clip.detail.revision}`}
          clip={clip}
          window={found.value}
          elements={dtd.value}
        />
      )}
    </div>
  );
}

function windowAt(clip: Clip, frame: number): [number, number] | null {
  if (!clip.frames) return null;
  const first = Math.floor((Math.max(1, Math.min(frame, clip.frames)) - 1) / FRAMES_AT_ONCE) * FRAMES_AT_ONCE + 1;
  return [first, Math.min(clip.frames, first + FRAMES_AT_ONCE - 1)];
}

function Editor({ clip, window: shown, elements }: { clip: Clip; window: Window; elements: ElementSpec[] }) {
  const host = useRef<HTMLDivElement>(null);
  const view = useRef<EditorView | null>(null);
  const [changed, setChanged] = useState(false);
  const [said, setSaid] = useState("");
  useEffect(() => {
    const shadow = host.current!.shadowRoot ?? host.current!.attachShadow({ mode: "open" });
    const inner = document.createElement("div");
    inner.style.height = "100%";
    shadow.replaceChildren(inner);
    const made = new EditorView({
      parent: inner,
      root: shadow,
      state: EditorState.create({
        doc: shown.text,
        extensions: [
          lineNumbers({ formatNumber: (line) => String(line + shown.firstLine - 1) }),
          foldGutter(),
          lintGutter(),
          history(),
          closeBrackets(),
          autocompletion(),
          xml({ elements }),
          syntaxHighlighting(colours),
          editorTheme,
          EditorState.readOnly.of(clip.pinned !== null),
          keymap.of([...closeBracketsKeymap, ...completionKeymap, ...historyKeymap, ...defaultKeymap]),
          EditorView.contentAttributes.of({ "aria-label": "MCML" }),
          EditorView.updateListener.of((update) => {
            if (update.docChanged) {
              setChanged(update.state.doc.toString() !== shown.text);
              setSaid("");
            }
          }),
        ],
      }),
    });
    view.current = made;
    made.scrollDOM.tabIndex = 0; // What scrolls is reached by keys.
    return () => made.destroy();
  }, []);

  const replacements = (): Replacement[] | null => {
    const text = view.current!.state.doc.toString();
    try {
      return shown.frames ? changedFrames(shown.text, text, shown.frames[0]) : changedParts(shown.text, text);
    } catch {
      setSaid(w("help.sameFrames"));
      return null;
    }
  };
  /** Ask the server whether it would take it; mark what it would not. */
  const check = async (): Promise<Replacement[] | null> => {
    const found = replacements();
    if (!found) return null;
    const elements = found.map((one) => ({ do: "replace" as const, xpath: one.address, fragment: one.fragment }));
    try {
      const answer = await ask("post", "/documents/{id}/changes", {
        path: { id: clip.id },
        query: { dry_run: true },
        match: clip.detail.revision,
        body: { ...asChanges({ samples: new Map(), labels: null, elements: new Map(), steps: 0 }), elements },
      });
      const marks = (answer.faults ?? []).map((fault): Diagnostic => {
        const base = fault.number === null || fault.number === undefined ? 1 : itemAt(found, fault.number).line;
        const state = view.current!.state;
        const line = state.doc.line(Math.max(1, Math.min(state.doc.lines, base + (fault.line ?? 1) - 1)));
        return {
          from: line.from,
          to: line.to,
          severity: "error",
          message: [fault.what, fault.remedy].filter(Boolean).join(" "),
        };
      });
      view.current!.dispatch(setDiagnostics(view.current!.state, marks));
      setSaid(
        marks.length ? `${w("label.faults", { n: marks.length })}: ${itemAt(marks, 0).message}` : w("help.noFaults"),
      );
      return marks.length ? null : found;
    } catch (error) {
      refuse(error);
      return null;
    }
  };
  const keep = async () => {
    const found = await check();
    if (!found?.length) return;
    let draft = clip.draft.peek();
    for (const one of found) {
      const frame = shown.frames ? Number(/frame\[(\d+)\]/.exec(one.address)![1]) : null;
      const samples = frame === null ? null : changedSamples(one.before, one.fragment);
      const from = draft;
      const sampled =
        samples &&
        frame !== null &&
        orReplaced(() =>
          [...samples].reduce((made, [track, value]) => withSamples(made, track, [[frame, value]]), from),
        );
      draft = sampled || withFragment(draft, one.address, one.fragment, frame);
    }
    clip.change({ ...draft, steps: clip.draft.peek().steps + 1 });
    setChanged(false);
  };
  return (
    <>
      <div ref={host} class="text-host" />
      <div class="row wrap text-foot">
        <span class="dim">
          {w("label.textWindow", {
            first: number(shown.firstLine),
            last: number(shown.firstLine + shown.text.split("\n").length - 1),
          })}{" "}
          / {number(shown.totalLines)}
        </span>
        <span class="grow" role="status">
          {said}
        </span>
        {changed && (
          <button type="button" class="button dense" onClick={() => void check()}>
            {w("button.check")}
          </button>
        )}
        {changed && (
          <button type="button" class="button dense primary" onClick={() => void keep()}>
            {w("button.apply")}
          </button>
        )}
      </div>
    </>
  );
}
