/** What is chosen of the storyboard, as fields: a piece, a seam, a layer. All that a drag does, a field does too. */
import { useState } from "preact/hooks";
import { PARTS, partNamed, partsOf } from "../../motion/body/parts";
import {
  FASTEST,
  LONGEST,
  SLOWEST,
  sizeOf,
  STYLES,
  type Layer,
  type Piece,
  type Style,
} from "../../state/editing/composition";
import { Dialog } from "../../ui/Dialog";
import { NumberField } from "../../ui/forms/NumberField";
import { Icon, type IconName } from "../../ui/icons";
import { number, w, type Word } from "../../words";
import type { Board } from "./board";
import { facts } from "./facts";
import { PART_WORDS } from "./partWords";
import { isRough, shiftOf, stepOf, type Composed, type Seam } from "./seams";

const LONGER = 2; // times, by one press

export function ChosenForm({ board, composed }: { board: Board; composed: Composed | null }) {
  const here = board.at.value;
  if (!here) return null;
  if (here.kind === "layer") return <LayerForm board={board} piece={here.piece} layer={here.layer} />;
  if (here.kind === "seam") return <SeamForm board={board} piece={here.piece} index={here.index} composed={composed} />;
  return <PieceForm board={board} piece={here.piece} index={here.index} />;
}

function Amount({
  word,
  value,
  least,
  most,
  step = 1,
  onChange,
}: {
  word: Word;
  value: number;
  least: number;
  most: number;
  step?: number;
  onChange: (value: number) => void;
}) {
  return (
    <label class="row">
      <span class="dim">{w(word)}</span>
      <NumberField
        least={least}
        most={most}
        step={step}
        value={value}
        onChange={(now) => now !== null && onChange(now)}
      />
    </label>
  );
}

const Act = ({
  icon,
  word,
  disabled,
  onClick,
}: {
  icon: IconName;
  word: Word;
  disabled?: boolean;
  onClick: () => void;
}) => (
  <button
    type="button"
    class="button quiet icon dense"
    aria-label={w(word)}
    title={w(word)}
    disabled={disabled}
    onClick={onClick}
  >
    <Icon name={icon} />
  </button>
);

function PieceForm({ board, piece, index }: { board: Board; piece: Piece; index: number }) {
  const set = (change: Partial<Piece>) => board.setPiece(piece.key, change);
  return (
    <div class="row wrap piece-form" role="group" aria-label={w("label.piece", { n: index + 1 })}>
      <strong>{w("label.piece", { n: index + 1 })}</strong>
      <Amount
        word="label.trimFrom"
        least={1}
        most={piece.last || 1}
        value={piece.first}
        onChange={(first) => set({ first })}
      />
      <Amount
        word="label.trimTo"
        least={piece.first}
        most={piece.frames || piece.last}
        value={piece.last}
        onChange={(last) => set({ last })}
      />
      <span class="dim">
        {w("label.frames", { n: sizeOf(piece) })} {w("label.ofFrames", { n: piece.frames })}
      </span>
      <Amount
        word="label.speed"
        least={SLOWEST}
        most={FASTEST}
        step={0.05}
        value={piece.speed}
        onChange={(speed) => set({ speed })}
      />
      <button
        type="button"
        class="button dense"
        aria-pressed={piece.mirror}
        onClick={() => set({ mirror: !piece.mirror })}
      >
        <Icon name="mirror" />
        {w("label.mirror")}
      </button>
      <span class="grow" />
      <Act icon="back" word="button.moveLeft" disabled={index === 0} onClick={() => board.move(-1)} />
      <Act
        icon="next"
        word="button.moveRight"
        disabled={index >= board.pieces.value.length - 1}
        onClick={() => board.move(1)}
      />
      <Act icon="trash" word="button.remove" onClick={board.remove} />
    </div>
  );
}

export function StyleChoice({
  label,
  value,
  usual,
  onChange,
}: {
  label: string;
  value: Style | null;
  usual?: Style;
  onChange: (style: Style | null) => void;
}) {
  return (
    <div class="segments" role="group" aria-label={label}>
      {usual && (
        <button type="button" aria-pressed={value === null} onClick={() => onChange(null)}>
          {w("label.asAll", { what: w(`label.${usual}`) })}
        </button>
      )}
      {STYLES.map((one) => (
        <button
          key={one}
          type="button"
          aria-pressed={value === one}
          title={w(`help.${one}Help`)}
          onClick={() => onChange(one)}
        >
          {w(`label.${one}`)}
        </button>
      ))}
    </div>
  );
}

function SeamForm({
  board,
  piece,
  index,
  composed,
}: {
  board: Board;
  piece: Piece;
  index: number;
  composed: Composed | null;
}) {
  const all = board.steps.now.value;
  const made = composed?.seams.find((one) => one.segment === index + 1);
  const length = piece.transition ?? made?.transition ?? all.transition ?? 0;
  const set = (change: Partial<Piece>) => board.setPiece(piece.key, change);
  return (
    <div class="row wrap piece-form" role="group" aria-label={w("label.seam")}>
      <strong>{w("label.seamBetween", { n: index, next: index + 1 })}</strong>
      <Amount
        word="label.transition"
        least={0}
        most={LONGEST}
        value={length}
        onChange={(transition) => set({ transition })}
      />
      <StyleChoice
        label={w("label.transitionStyle")}
        value={piece.style}
        usual={all.style}
        onChange={(style) => set({ style })}
      />
      {(piece.transition !== null || piece.style !== null) && (
        <button type="button" class="button quiet dense" onClick={() => set({ transition: null, style: null })}>
          {w("button.asAllSeams")}
        </button>
      )}
      {made ? (
        <span class={isRough(made) ? "seam-report rough" : "seam-report dim"} role="status">
          <Icon name={isRough(made) ? "warn" : "check"} />
          {w(isRough(made) ? "help.seamRough" : "help.seamSmooth", { step: number(stepOf(made), 2) })}{" "}
          {w("help.seamPlaced", { degrees: number(made.degrees, 1), shift: number(shiftOf(made), 1) })} {feetOf(made)}
        </span>
      ) : (
        composed && <span class="dim">{w("help.seamNone")}</span>
      )}
      {made && isRough(made) && (
        <button type="button" class="button dense" onClick={() => set({ transition: Math.max(1, length) * LONGER })}>
          {w("button.seamLonger", { n: Math.max(1, length) * LONGER })}
        </button>
      )}
    </div>
  );
}

/** How a seam treats feet and how sudden it is, in words. */
function feetOf(seam: Seam): string {
  const jerk = w("help.seamJerk", { jerk: number(seam.jerk, 2) });
  const [before, after] = seam.left_out;
  const leftOut = before || after ? [w("help.leftOut", { before, after })] : [];
  if (seam.slide == null) return jerk;
  const held =
    seam.locked.length > 1 ? "help.feetHeld" : seam.locked[0] === "left" ? "help.leftHeld" : "help.rightHeld";
  const slide = w("help.seamSlide", { speed: number(seam.slide, 2) });
  return [jerk, slide, seam.locked.length ? w(held) : w("help.noneHeld"), ...leftOut].join(" ");
}

function LayerForm({ board, piece, layer }: { board: Board; piece: Piece; layer: Layer }) {
  const [choosing, setChoosing] = useState(false);
  const body = facts.value.get(board.pieces.value[0]?.document ?? "")?.skeleton.view.bones ?? [];
  const parts = partsOf(body);
  const part = partNamed(body, layer.bones) ?? "";
  const set = (change: Partial<Layer>, kind = "") => board.setLayer(layer.key, change, kind);
  return (
    <div class="row wrap piece-form" role="group" aria-label={w("label.layer")}>
      <strong class="cut">
        {w("label.layer")}: {layer.name}
      </strong>
      <label class="row">
        <span class="dim">{w("label.joints")}</span>
        <select
          class="field"
          value={part}
          onChange={(event) => {
            const chosen = event.currentTarget.value as (typeof PARTS)[number] | "";
            if (chosen) set({ bones: parts[chosen] });
            else setChoosing(true);
          }}
        >
          {PARTS.filter((one) => parts[one].length).map((one) => (
            <option key={one} value={one}>
              {w(PART_WORDS[one])}
            </option>
          ))}
          <option value="">{part ? w("button.chooseJoints") : w("label.jointCount", { n: layer.bones.length })}</option>
        </select>
      </label>
      <button type="button" class="button quiet dense" onClick={() => setChoosing(true)}>
        {w("button.chooseJoints")}
      </button>
      <Amount
        word="label.layerAt"
        least={1}
        most={Math.max(1, sizeOf(piece))}
        value={layer.at}
        onChange={(at) => set({ at })}
      />
      <Amount
        word="label.trimFrom"
        least={1}
        most={layer.last || 1}
        value={layer.first}
        onChange={(first) => set({ first })}
      />
      <Amount
        word="label.trimTo"
        least={layer.first}
        most={layer.frames || layer.last}
        value={layer.last}
        onChange={(last) => set({ last })}
      />
      <label class="row">
        <span class="dim">{w("label.strength")}</span>
        <input
          type="range"
          min={0}
          max={1}
          step={0.05}
          value={layer.strength}
          aria-label={w("label.strength")}
          onChange={(event) => set({ strength: event.currentTarget.valueAsNumber })}
        />
      </label>
      <Amount word="label.ease" least={0} most={LONGEST} value={layer.ease} onChange={(ease) => set({ ease })} />
      <span class="grow" />
      <Act icon="trash" word="button.remove" onClick={board.remove} />
      {choosing && (
        <Dialog title={w("button.chooseJoints")} onClose={() => setChoosing(false)}>
          <p class="dim">{w("help.chooseJointsHelp")}</p>
          <div class="joint-choice">
            {body.map((bone) => (
              <label key={bone.name} class="row">
                <input
                  type="checkbox"
                  checked={layer.bones.includes(bone.name)}
                  onChange={() => toggleBone(board, layer, bone.name)}
                />
                <span class="dot" style={{ background: `var(--${bone.side})` }} />
                <span class="cut">{bone.name}</span>
              </label>
            ))}
          </div>
        </Dialog>
      )}
    </div>
  );
}

/** Take a bone into a layer, or out of it; the last one stays. */
export function toggleBone(board: Board, layer: Layer, bone: string): void {
  const next = layer.bones.includes(bone) ? layer.bones.filter((one) => one !== bone) : [...layer.bones, bone];
  if (next.length) board.setLayer(layer.key, { bones: next }, "bones");
}
