/** A new clip of stored ones: pieces in a row, trimmed, ordered, with layers upon them, seen before they are saved. */
import { useEffect, useMemo, useState } from "preact/hooks";
import { ask, type Schemas } from "../../api/client";
import { subject } from "../../state/session/shell";
import { stepFor } from "../../motion/loading/preview";
import { asRequest, sizeOf } from "../../state/editing/composition";
import { demoClips, isEmpty } from "../../state/library/demo";
import { offer } from "../../state/session/keys";
import { note, refuse } from "../../state/session/notes";
import { go, setParams } from "../../state/session/route";
import { Icon } from "../../ui/icons";
import { EmptyState } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { duration, w } from "../../words";
import { Bin } from "./Bin";
import { Board, carried, draft } from "./board";
import { ComposedView } from "./ComposedView";
import { askFacts, facts } from "./facts";
import { AllSeams } from "./AllSeams";
import { ChosenForm } from "./Forms";
import type { Composed } from "./seams";
import { Storyboard } from "./Storyboard";
import "../../styles/composer.css";

const WAIT = 250; // ms after the last change
const SLACK = 1.3; // previews may get longer: transitions are lengthened

export function ComposerPage() {
  const board = useMemo(() => new Board(), []);
  const [saving, setSaving] = useState(false);
  const now = board.steps.now.value;
  const { name, seconds, transition } = now;
  const pieces = board.pieces.value;
  const known = facts.value;

  useEffect(() => {
    askFacts(pieces.flatMap((one) => [one.document, ...one.layers.map((layer) => layer.document)]));
    board.learn();
  }, [pieces, known]);
  useEffect(() => {
    const written = board.written;
    setParams(written);
    draft.value = written.s
      ? new URLSearchParams(
          Object.entries(written).filter((one): one is [string, string] => one[1] !== null),
        ).toString()
      : "";
  }, [board.steps.now.value]);

  const body = known.get(pieces[0]?.document ?? "");
  const ready =
    pieces.length > 0 &&
    pieces.every((one) => one.frames && one.layers.every((layer) => layer.frames)) &&
    body !== undefined;
  // Compared as text: what was learnt of a clip, or a key, is no change.
  const asked = ready ? JSON.stringify(asRequest(now)) : "";
  const preview = useAsync<Composed | null>(
    async (signal) => {
      if (!ready) return null;
      await new Promise((resolve) => setTimeout(resolve, WAIT));
      signal.throwIfAborted();
      const length = pieces.reduce(
        (sum, one) => sum + sizeOf(one) / (known.get(one.document)?.perSecond ?? body.perSecond) / one.speed,
        0,
      );
      const usual = transition ?? Math.round(seconds * body.perSecond);
      const between = pieces.slice(1).reduce((sum, one) => sum + (one.transition ?? usual), 0);
      const step = stepFor((length * body.perSecond + between) * SLACK, body.skeleton.points);
      const answer = await ask("post", "/compose", {
        body: { ...JSON.parse(asked), preview: true } as Schemas["ComposeRequest"],
        query: { positions: "f4", step },
        signal,
      });
      return { ...answer, step, skeleton: body.skeleton };
    },
    [asked],
  );

  const save = async () => {
    if (!ready || saving || !name.trim()) return;
    setSaving(true);
    try {
      const made = await ask("post", "/compose", { body: { ...JSON.parse(asked), name } as Schemas["ComposeRequest"] });
      draft.value = "";
      const open = () => go(`/clips/${made.document}`);
      note(w("label.composed", { name }), { action: { text: w("button.open"), run: open } });
      open();
    } catch (error) {
      refuse(error);
    } finally {
      setSaving(false);
    }
  };
  const saveNow = useMemo(() => ({ run: save }), []);
  saveNow.run = save;
  useEffect(() => {
    subject.value = null;
    return offer("composer", [
      { id: "undo", word: "button.undo", keys: ["Ctrl+Z"], run: () => board.steps.undo() },
      { id: "redo", word: "button.redo", keys: ["Ctrl+Shift+Z", "Ctrl+Y"], run: () => board.steps.redo() },
      { id: "split", word: "button.split", keys: ["S"], run: board.split },
      { id: "delete", word: "button.remove", keys: ["Del"], run: board.remove },
      { id: "left", word: "button.moveLeft", keys: ["Alt+Left"], run: () => board.move(-1) },
      { id: "right", word: "button.moveRight", keys: ["Alt+Right"], run: () => board.move(1) },
      { id: "save", word: "button.save", keys: ["Ctrl+S"], run: () => void saveNow.run() },
    ]);
  }, []);
  /** While a change is worked out the preview before stays, dimmed. */
  const shown = pieces.length ? ((preview.value === undefined ? preview.before : preview.value) ?? null) : null;
  return (
    <div class="composer">
      <h1 class="unseen">{w("label.compose")}</h1>
      <aside class="bin" aria-label={w("label.bin")}>
        <Bin board={board} />
      </aside>
      <section class="composer-main">
        <div class="clip-bar row">
          <input
            class="field composer-name"
            aria-label={w("label.newName")}
            value={name}
            onInput={(event) => board.rename(event.currentTarget.value)}
          />
          <span class="dim" role="status">
            {shown && w("label.total", { time: duration(shown.frames * shown.seconds_per_frame), n: pieces.length })}
          </span>
          <span class="grow" />
          <button
            type="button"
            class="button quiet icon"
            aria-label={w("button.undo")}
            title={w("button.undo")}
            disabled={!board.steps.canUndo.value}
            onClick={() => board.steps.undo()}
          >
            <Icon name="undo" />
          </button>
          <button
            type="button"
            class="button quiet icon"
            aria-label={w("button.redo")}
            title={w("button.redo")}
            disabled={!board.steps.canRedo.value}
            onClick={() => board.steps.redo()}
          >
            <Icon name="redo" />
          </button>
          {pieces.length > 0 && (
            <button
              type="button"
              class="button quiet icon"
              aria-label={w("button.startAnew")}
              title={w("button.startAnew")}
              onClick={board.clear}
            >
              <Icon name="close" />
            </button>
          )}
          <button
            type="button"
            class="button primary"
            disabled={!ready || saving || !name.trim()}
            onClick={() => void save()}
          >
            {w("button.saveAsClip")}
          </button>
        </div>
        <div class="clip-bar row seams-bar">
          <AllSeams board={board} body={body} />
        </div>
        <Trouble error={pieces.length ? preview.error : null} retry={preview.again} />
        {(shown?.notices.length ?? 0) > 0 && (
          <details class="notice dim">
            <summary>
              {w("label.notices")} ({shown!.notices.length})
            </summary>
            {shown!.notices.map((one) => (
              <p key={one}>{one}</p>
            ))}
          </details>
        )}
        {pieces.length ? (
          <>
            <div class="composer-busy">{preview.busy && <div class="busy" />}</div>
            <div class={`composed ${preview.value ? "" : "stale"}`} aria-busy={preview.busy}>
              {shown ? <ComposedView composed={shown} board={board} /> : <div class="composed-view" />}
            </div>
            <div class="storyboard">
              <Storyboard board={board} composed={shown} />
              <ChosenForm board={board} composed={preview.busy ? null : shown} />
            </div>
          </>
        ) : (
          <div
            class="composer-empty"
            onDragOver={(event) => event.preventDefault()}
            onDrop={(event) => board.add(carried(event))}
          >
            <Invitation board={board} />
          </div>
        )}
      </section>
    </div>
  );
}

/** What an empty storyboard says. */
const Invitation = ({ board }: { board: Board }) => (
  <EmptyState
    picture="compose"
    title={w("label.composeEmpty")}
    makes={w("help.composeMakes")}
    needs={w("help.dragHere")}
    parts={["people"]}
    onDemo={async () => {
      const [walk, dance] = await demoClips("walk_1", "dance_1");
      if (walk && dance) board.add([{ ...walk, first: 1, last: 150 }, dance]);
    }}
  >
    {!isEmpty.value && <p class="dim">{w("help.layersHelp")}</p>}
    {!isEmpty.value && <p class="dim">{w("help.fitOnAdd")}</p>}
  </EmptyState>
);
