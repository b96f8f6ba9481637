/** What is chosen of an export: the target, and how the motion is written. */
import { characters } from "../../state/clip/characters";
import { LANGUAGE, presets, writtenFormats } from "../../state/session/formats";
import { number, w } from "../../words";
import { NumberField } from "../forms/NumberField";
import { UNITS, type ExportOptions } from "./exportOptions";

const AXES = ["X", "Y", "Z"];
const TALLEST = 100; // metres

/** skins: whether it can have a body with a skin. */
export interface Target {
  key: string;
  text: string;
  unit: string | null;
  skins: boolean;
}

/** Programs and formats that hold clips of a kind, or of any; their names are "for:…" and "format:…". */
export function targetsOf(holds?: "markers" | "bodies"): Target[] {
  const skinned = new Set(writtenFormats("bodies").flatMap(({ name, skins }) => (skins ? [name] : [])));
  return [
    ...presets(holds ?? "bodies").map(({ preset }) => ({
      key: `for:${preset.name}`,
      text: w("label.exportFor", { program: preset.title }),
      unit: preset[holds ?? "bodies"].unit ?? null,
      skins: [preset.bodies, preset.markers].some((shape) => skinned.has(shape.format)),
    })),
    ...writtenFormats(holds)
      .filter(({ name }) => name !== LANGUAGE)
      .map(({ name, label, assumes }) => ({
        key: `format:${name}`,
        text: label,
        unit: assumes,
        skins: skinned.has(name),
      })),
  ];
}

export const targetOf = (key: string): ExportOptions["target"] => {
  const [kind, name] = [key.slice(0, key.indexOf(":")), key.slice(key.indexOf(":") + 1)];
  return kind === "for" ? { for: name } : { format: name };
};

/** What is known of the clips: a unit and an axis to change, and one frame rate. */
export interface Known {
  unit: boolean;
  up: boolean;
  rate: number | null;
}

export const START: Omit<ExportOptions, "target"> = {
  unit: "",
  up: "",
  fps: null,
  height: null,
  inPlace: false,
  character: "",
  range: null,
};

export function TargetChoice({
  targets,
  chosen,
  onChoose,
}: {
  targets: readonly Target[];
  chosen: Target;
  onChoose: (key: string) => void;
}) {
  return (
    <label>
      {w("label.exportTarget")}
      <select class="field" value={chosen.key} onChange={(event) => onChoose(event.currentTarget.value)}>
        {targets.map((one) => (
          <option key={one.key} value={one.key}>
            {one.text}
          </option>
        ))}
      </select>
    </label>
  );
}

export type Given = Omit<ExportOptions, "target">;

export function ExportFields({
  known,
  loop,
  given,
  target,
  onChange,
}: {
  known: Known;
  /** Frames that can be exported alone. */
  loop: [number, number] | null;
  given: Given;
  target: Target;
  onChange: (more: Partial<Given>) => void;
}) {
  const { unit } = target;
  return (
    <>
      <label>
        {w("label.unit")}
        <select
          class="field"
          value={given.unit}
          disabled={!known.unit}
          title={known.unit ? undefined : w("label.needsUnit")}
          onChange={(event) => onChange({ unit: event.currentTarget.value })}
        >
          <option value="">{unit ? w("label.asTarget", { value: unit }) : w("label.asInClip")}</option>
          {Object.keys(UNITS).map((one) => (
            <option key={one}>{one}</option>
          ))}
        </select>
      </label>
      <label>
        {w("label.up")}
        <select
          class="field"
          value={given.up}
          disabled={!known.up}
          onChange={(event) => onChange({ up: event.currentTarget.value })}
        >
          <option value="">{w("label.automaticChoice")}</option>
          {AXES.map((one) => (
            <option key={one}>{one}</option>
          ))}
        </select>
      </label>
      <label>
        {w("label.frameRate")}
        <NumberField
          value={given.fps}
          least={0.001}
          placeholder={known.rate === null ? w("label.asInClip") : number(known.rate, 2)}
          onChange={(fps) => onChange({ fps: fps && fps > 0 ? fps : null })}
        />
      </label>
      <label>
        {w("label.standsTall")}
        <NumberField
          value={given.height}
          least={0.01}
          most={TALLEST}
          step={0.01}
          placeholder={w("label.asInClip")}
          onChange={(height) => onChange({ height: height && height > 0 && height <= TALLEST ? height : null })}
        />
      </label>
      <label class="row check">
        <input
          type="checkbox"
          checked={given.inPlace}
          onChange={(event) => onChange({ inPlace: event.currentTarget.checked })}
        />
        {w("label.exportInPlace")}
      </label>
      {target.skins && (
        <label>
          {w("label.exportBody")}
          <select
            class="field"
            value={given.character}
            onChange={(event) => onChange({ character: event.currentTarget.value })}
          >
            <option value="">{w("label.exportBones")}</option>
            <option value="own">{w("label.ownBody")}</option>
            {characters.value.map((one) => (
              <option key={one.document} value={one.document}>
                {one.name}
              </option>
            ))}
          </select>
        </label>
      )}
      {loop && (
        <label class="row check">
          <input
            type="checkbox"
            checked={given.range !== null}
            onChange={(event) => onChange({ range: event.currentTarget.checked ? loop : null })}
          />
          {w("label.onlyLoop", { first: loop[0], last: loop[1] })}
        </label>
      )}
    </>
  );
}
