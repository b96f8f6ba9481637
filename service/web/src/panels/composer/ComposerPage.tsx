/** A new clip of stored ones: pieces in a row, trimmed, ordered, seen before they are saved. */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import { ask, type Schemas } from "../../api/client";
import { subject } from "../../shell/Bar";
import { movePiece, parsePieces, pieceOf, splitPiece, writePieces, type Piece } from "../../state/composition";
import { offer } from "../../state/keys";
import { note, refuse } from "../../state/notes";
import { go, param, setParams } from "../../state/route";
import { stepFor } from "../../motion/preview";
import type { Skeleton } from "../../motion/skeleton";
import { motionOf } from "../../motion/source";
import { Icon } from "../../ui/icons";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { duration, w } from "../../words";
import { Bin } from "./Bin";
import { ComposedView } from "./ComposedView";
import { Storyboard } from "./Storyboard";
import "../../styles/composer.css";

export type Composed = Schemas["Composed"] & { step: number; skeleton: Skeleton };

export function ComposerPage() {
  const pieces = useSignal<Piece[]>(parsePieces(param("s")));
  const transition = useSignal(Number(param("t") || 12));
  const style = useSignal<"bridge" | "crossfade">(param("style") === "crossfade" ? "crossfade" : "bridge");
  const selected = useSignal(0);
  const done = useSignal<Piece[][]>([]);
  const undone = useSignal<Piece[][]>([]);
  const [name, setName] = useState(param("name") || w("untitled"));
  const [saving, setSaving] = useState(false);

  const change = (next: Piece[]) => {
    done.value = [...done.peek(), pieces.peek()];
    undone.value = [];
    pieces.value = next;
  };
  const undo = () => {
    const before = done.peek().at(-1);
    if (!before) return;
    done.value = done.peek().slice(0, -1);
    undone.value = [...undone.peek(), pieces.peek()];
    pieces.value = before;
  };
  const redo = () => {
    const next = undone.peek().at(-1);
    if (!next) return;
    undone.value = undone.peek().slice(0, -1);
    done.value = [...done.peek(), pieces.peek()];
    pieces.value = next;
  };

  // What pieces are called and how long their clips are comes with their skeletons.
  useEffect(() => {
    for (const piece of pieces.value) {
      if (piece.frames) continue;
      motionOf(piece.document).then((motion) => {
        pieces.value = pieces.peek().map((one) => (one.key === piece.key ? { ...one, name: motion.name, frames: motion.frames, last: one.last ? Math.min(one.last, motion.frames) : motion.frames } : one));
      }, refuse);
    }
    setParams({ s: writePieces(pieces.value) || null, t: transition.value === 12 ? null : String(transition.value), style: style.value === "bridge" ? null : style.value });
  }, [pieces.value, transition.value, style.value]);

  const ready = pieces.value.length > 0 && pieces.value.every((one) => one.frames);
  const request = useMemo(() => ({
    segments: pieces.value.map((one) => ({ document: one.document, first: one.first, last: one.last })),
    transition: transition.value, style: style.value, name,
  }), [pieces.value, transition.value, style.value, name]);
  const preview = useAsync(async (signal) => {
    if (!ready) return null;
    await new Promise((resolve) => setTimeout(resolve, 250));
    signal.throwIfAborted();
    const body = await motionOf(pieces.peek()[0].document);
    const frames = pieces.peek().reduce((sum, one) => sum + one.last - one.first + 1, 0);
    const step = stepFor(frames * 1.2, body.skeleton.points);
    const answer = await ask("post", "/compose", { body: { ...request, preview: true } as Schemas["ComposeRequest"], query: { positions: "f4", step }, signal });
    return { ...answer, step, skeleton: body.skeleton };
  }, [ready, request.segments, request.transition, request.style]);

  const save = async () => {
    setSaving(true);
    try {
      const made = await ask("post", "/compose", { body: request as Schemas["ComposeRequest"] });
      note(w("composed", { name }), { action: { text: w("open"), run: () => go(`/clips/${made.document}`) } });
      go(`/clips/${made.document}`);
    } catch (error) {
      refuse(error);
    } finally {
      setSaving(false);
    }
  };
  const add = (document: string, label: string, first = 1, last = 0) => {
    change([...pieces.peek(), pieceOf(document, label, first, last)]);
    selected.value = pieces.peek().length - 1;
  };
  const playhead = useSignal(0);
  const actions = {
    split: () => change(splitPiece(pieces.peek(), selected.peek(), playhead.peek() + 1)),
    remove: () => { change(pieces.peek().filter((_, at) => at !== selected.peek())); selected.value = Math.max(0, selected.peek() - 1); },
    move: (by: number) => {
      const to = selected.peek() + by;
      if (to < 0 || to >= pieces.peek().length) return;
      change(movePiece(pieces.peek(), selected.peek(), to));
      selected.value = to;
    },
  };
  useEffect(() => {
    subject.value = null;
    return offer("composer", [
      { id: "undo", word: "undo", keys: ["Ctrl+Z"], run: undo },
      { id: "redo", word: "redo", keys: ["Ctrl+Shift+Z", "Ctrl+Y"], run: redo },
      { id: "split", word: "split", keys: ["S"], run: actions.split },
      { id: "delete", word: "remove", keys: ["Del"], run: actions.remove },
      { id: "left", word: "moveLeft", keys: ["Alt+Left"], run: () => actions.move(-1) },
      { id: "right", word: "moveRight", keys: ["Alt+Right"], run: () => actions.move(1) },
      { id: "save", word: "save", keys: ["Ctrl+S"], run: () => void save() },
    ]);
  });
  return (
    <div class="composer">
      <h1 class="unseen">{w("compose")}</h1>
      <aside class="bin" aria-label={w("bin")}><Bin onAdd={add} /></aside>
      <section class="composer-main">
        <div class="clip-bar row">
          <input class="field composer-name" aria-label={w("newName")} value={name} onInput={(event) => setName(event.currentTarget.value)} />
          <span class="dim" role="status">{preview.value ? w("total", { time: duration(preview.value.frames * preview.value.seconds_per_frame), n: pieces.value.length }) : ""}</span>
          <span class="grow" />
          <button type="button" class="button quiet icon" aria-label={w("undo")} disabled={!done.value.length} onClick={undo}><Icon name="undo" /></button>
          <button type="button" class="button quiet icon" aria-label={w("redo")} disabled={!undone.value.length} onClick={redo}><Icon name="redo" /></button>
          <label class="row"><span class="dim">{w("transition")}</span><input class="field number" type="number" min={0} max={500} value={transition.value} onInput={(event) => (transition.value = Math.max(0, Number(event.currentTarget.value)))} /></label>
          <div class="segments" role="group" aria-label={w("transition")}>
            <button type="button" aria-pressed={style.value === "bridge"} onClick={() => (style.value = "bridge")}>{w("bridge")}</button>
            <button type="button" aria-pressed={style.value === "crossfade"} onClick={() => (style.value = "crossfade")}>{w("crossfade")}</button>
          </div>
          <button type="button" class="button primary" disabled={!ready || saving || !name.trim()} onClick={() => void save()}>{w("saveAsClip")}</button>
        </div>
        <Trouble error={preview.error} retry={preview.again} />
        {(preview.value?.notices.length ?? 0) > 0 && <details class="notice dim"><summary>{w("notices")} ({preview.value!.notices.length})</summary>{preview.value!.notices.map((one) => <p key={one}>{one}</p>)}</details>}
        {pieces.value.length ? (
          <>
            {preview.value ? <ComposedView composed={preview.value} selected={selected.value} onPlace={(frame) => (playhead.value = frame)} /> : <div class="composed-view">{preview.busy && <div class="busy" />}</div>}
            <Storyboard pieces={pieces.value} composed={preview.value ?? null} selected={selected.value} onSelect={(index) => (selected.value = index)} onChange={change} onDropClip={add} />
          </>
        ) : (
          <div class="empty" onDragOver={(event) => event.preventDefault()} onDrop={(event) => dropped(event, add)}><h2>{w("composeEmpty")}</h2><p>{w("dragHere")}</p><p class="dim">{w("fitOnAdd")}</p></div>
        )}
      </section>
    </div>
  );
}

export function dropped(event: DragEvent, add: (document: string, name: string) => void): void {
  const text = event.dataTransfer?.getData("application/x-mcml-clip");
  if (!text) return;
  event.preventDefault();
  const { id, name } = JSON.parse(text) as { id: string; name: string };
  add(id, name);
}
