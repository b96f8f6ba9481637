/** The pieces in their order, as wide as they are long. Edges trim, the middle moves, numbers do both. */
import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { movePiece, type Piece } from "../../state/composition";
import { Icon } from "../../ui/icons";
import { number, w } from "../../words";
import { dropped, type Composed } from "./ComposerPage";

const ROUGH = 1.5; // a step over a seam, in parts of the largest inside the pieces
const EDGE = 8;

export function Storyboard({ pieces, composed, selected, onSelect, onChange, onDropClip }: {
  pieces: readonly Piece[];
  composed: Composed | null;
  selected: number;
  onSelect: (index: number) => void;
  onChange: (pieces: Piece[]) => void;
  onDropClip: (document: string, name: string) => void;
}) {
  const strip = useRef<HTMLDivElement>(null);
  const trial = useSignal<Piece | null>(null);
  const whole = pieces.reduce((sum, one) => sum + Math.max(1, one.last - one.first + 1), 0) || 1;
  const piece = pieces[Math.min(selected, pieces.length - 1)];
  const set = (index: number, change: Partial<Piece>) => {
    const one = { ...pieces[index], ...change };
    one.first = Math.max(1, Math.min(one.first, one.last));
    one.last = Math.min(one.frames || one.last, Math.max(one.last, one.first));
    onChange(pieces.map((each, at) => (at === index ? one : each)));
  };
  const take = (event: PointerEvent, index: number) => {
    if (event.button) return;
    onSelect(index);
    const element = event.currentTarget as HTMLElement;
    const box = element.getBoundingClientRect();
    const one = pieces[index];
    const edge = event.clientX - box.left < EDGE ? "first" : box.right - event.clientX < EDGE ? "last" : null;
    const perPixel = whole / strip.current!.clientWidth;
    element.setPointerCapture(event.pointerId);
    element.onpointermove = (move) => {
      const by = Math.round((move.clientX - event.clientX) * perPixel);
      if (edge === "first") trial.value = { ...one, first: Math.max(1, Math.min(one.last, one.first + by)) };
      if (edge === "last") trial.value = { ...one, last: Math.min(one.frames, Math.max(one.first, one.last + by)) };
    };
    element.onpointerup = (up) => {
      element.onpointermove = element.onpointerup = null;
      if (trial.value) onChange(pieces.map((each, at) => (at === index ? trial.value! : each)));
      else if (!edge) {
        const place = [...strip.current!.querySelectorAll<HTMLElement>(".piece")].findIndex((other) => { const there = other.getBoundingClientRect(); return up.clientX < there.right; });
        const to = place < 0 ? pieces.length - 1 : place;
        if (to !== index) { onChange(movePiece(pieces, index, to)); onSelect(to); }
      }
      trial.value = null;
    };
  };
  return (
    <div class="storyboard" onDragOver={(event) => event.preventDefault()} onDrop={(event) => dropped(event, onDropClip)}>
      <div ref={strip} class="pieces" role="listbox" aria-label={w("pieces")} aria-orientation="horizontal">
        {pieces.map((each, index) => {
          const one = trial.value?.key === each.key ? trial.value : each;
          const seam = composed?.seams.find((other) => other.segment === index + 1);
          const rough = seam && (seam.root_step > ROUGH || seam.angle_step > ROUGH);
          return (
            <div key={each.key} class="piece-slot" style={{ flexGrow: Math.max(1, one.last - one.first + 1) / whole }}>
              {index > 0 && <span class={`seam ${rough ? "rough" : ""}`} title={seam ? `${w("seam")}: ${number(seam.transition)}, ${number(seam.degrees, 1)}°, ${number(Math.max(seam.root_step, seam.angle_step), 2)}` : ""}>{seam ? number(seam.transition) : "…"}</span>}
              <button type="button" class="piece" role="option" aria-selected={index === selected} tabIndex={index === selected ? 0 : -1}
                onPointerDown={(event) => take(event, index)} onFocus={() => onSelect(index)}
                onKeyDown={(event) => { const to = { ArrowLeft: index - 1, ArrowRight: index + 1 }[event.key]; if (to !== undefined && !event.altKey && pieces[to]) { onSelect(to); strip.current?.querySelectorAll<HTMLElement>(".piece")[to]?.focus(); event.preventDefault(); event.stopPropagation(); } }}>
                <span class="unseen">{w("piece", { n: index + 1 })}: </span><strong class="cut">{one.name || "…"}</strong><span class="dim cut">{number(one.first)}–{number(one.last)}</span>
              </button>
            </div>
          );
        })}
      </div>
      {piece && (
        <div class="row wrap piece-form">
          <strong>{w("piece", { n: selected + 1 })}</strong>
          <label class="row"><span class="dim">{w("trimFrom")}</span><input class="field number" type="number" min={1} max={piece.last} value={piece.first} onChange={(event) => set(selected, { first: Number(event.currentTarget.value) })} /></label>
          <label class="row"><span class="dim">{w("trimTo")}</span><input class="field number" type="number" min={piece.first} max={piece.frames} value={piece.last} onChange={(event) => set(selected, { last: Number(event.currentTarget.value) })} /></label>
          <span class="dim">{w("frames", { n: piece.last - piece.first + 1 })} {w("ofFrames", { n: piece.frames })}</span>
          <span class="grow" />
          <button type="button" class="button quiet icon dense" aria-label={w("moveLeft")} disabled={selected === 0} onClick={() => { onChange(movePiece(pieces, selected, selected - 1)); onSelect(selected - 1); }}><Icon name="back" /></button>
          <button type="button" class="button quiet icon dense" aria-label={w("moveRight")} disabled={selected >= pieces.length - 1} onClick={() => { onChange(movePiece(pieces, selected, selected + 1)); onSelect(selected + 1); }}><Icon name="next" /></button>
          <button type="button" class="button quiet icon dense" aria-label={w("remove")} onClick={() => { onChange(pieces.filter((_, at) => at !== selected)); onSelect(Math.max(0, selected - 1)); }}><Icon name="trash" /></button>
        </div>
      )}
    </div>
  );
}
