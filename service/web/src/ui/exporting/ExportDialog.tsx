/** A clip exported for a program or in a format, in a size, at a rate, in place; its height in the file is drawn. */
import { useEffect, useState } from "preact/hooks";
import { fetched, get, type Schemas } from "../../api/client";
import { characters, loadCharacters } from "../../state/clip/characters";
import type { Clip } from "../../state/clip/clip";
import { LANGUAGE, presets, writtenFormats } from "../../state/session/formats";
import { needsToken } from "../../state/session/me";
import { refuse } from "../../state/session/notes";
import { number, w } from "../../words";
import { Dialog } from "../Dialog";
import { NumberField } from "../forms/NumberField";
import { useAsync } from "../useAsync";
import {
  exportAddress,
  exportByCommand,
  exportByCurl,
  fileNameOf,
  rulerOf,
  UNITS,
  type ExportOptions,
} from "./exportOptions";
import { RuledFigure } from "./RuledFigure";
import { saveBlob } from "./saveBlob";
import { ScriptLines } from "./ScriptLines";
import "../../styles/shared.css";

const AXES = ["X", "Y", "Z"];
const TALLEST = 100; // metres

/** skins: whether it can have a body with a skin. */
interface Target {
  key: string;
  text: string;
  unit: string | null;
  skins: boolean;
}

/** Programs and formats that hold the clip; their names are "for:…" and "format:…". */
function targetsOf(markers: boolean): Target[] {
  const holds = markers ? "markers" : "bodies";
  const skinned = new Set(writtenFormats("bodies").flatMap(({ name, skins }) => (skins ? [name] : [])));
  return [
    ...presets(holds).map(({ preset }) => ({
      key: `for:${preset.name}`,
      text: w("label.exportFor", { program: preset.title }),
      unit: preset[holds].unit ?? null,
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

const targetOf = (key: string): ExportOptions["target"] => {
  const [kind, name] = [key.slice(0, key.indexOf(":")), key.slice(key.indexOf(":") + 1)];
  return kind === "for" ? { for: name } : { format: name };
};

export function ExportDialog({
  clip,
  range,
  onClose,
}: {
  clip: Clip;
  /** The loop, which can be exported alone. */
  range: [number, number] | null;
  onClose: () => void;
}) {
  const targets = targetsOf(clip.skeleton.view.markers);
  const [key, setKey] = useState<string | null>(null);
  const [given, setGiven] = useState<Omit<ExportOptions, "target">>({
    unit: "",
    up: "",
    fps: null,
    height: null,
    inPlace: false,
    character: "",
    range,
  });
  useEffect(() => void loadCharacters(), []);
  const [busy, setBusy] = useState(false);
  const [told, setTold] = useState<{ name: string; notices: string } | null>(null);
  const chosen = targets.find((one) => one.key === key) ?? targets[0];
  const change = (more: Partial<typeof given>) => {
    setTold(null);
    setGiven({ ...given, ...more });
  };
  if (!chosen) return null;
  const options: ExportOptions = {
    ...given,
    character: chosen.skins ? given.character : "",
    target: targetOf(chosen.key),
  };
  const revision = clip.pinned ?? undefined;
  const download = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    try {
      const answer = await fetched(exportAddress(clip.id, options, revision));
      const name = fileNameOf(answer.headers.get("content-disposition"), clip.detail.name);
      saveBlob(await answer.blob(), name);
      setTold({ name, notices: answer.headers.get("x-mcml-notices") ?? "" });
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <Dialog title={w("button.exportOptions")} onClose={onClose} wide>
      <form class="export-form" onSubmit={(event) => void download(event)}>
        <div class="export-fields">
          <label>
            {w("label.exportTarget")}
            <select
              class="field"
              value={chosen.key}
              onChange={(event) => {
                setTold(null);
                setKey(event.currentTarget.value);
              }}
            >
              {targets.map((one) => (
                <option key={one.key} value={one.key}>
                  {one.text}
                </option>
              ))}
            </select>
          </label>
          <Fields clip={clip} loop={range} given={given} target={chosen} onChange={change} />
        </div>
        <Measured clip={clip} given={given} unit={given.unit || chosen.unit || clip.detail.unit || ""} />
        <Lines id={clip.id} options={options} />
        <div class="row export-done">
          <div class="grow" role="status">
            {told && <Done name={told.name} notices={told.notices} />}
          </div>
          <button type="submit" class="button primary" disabled={busy}>
            {busy ? w("label.loading") : w("button.exportWord")}
          </button>
        </div>
      </form>
    </Dialog>
  );
}

/** notices: of the answer, with bars between them. */
function Done({ name, notices }: { name: string; notices: string }) {
  return (
    <>
      <strong>{w("label.exported", { name })}</strong>
      <ul class="dim">
        {notices
          .split(" | ")
          .filter(Boolean)
          .map((one) => (
            <li key={one}>{one}</li>
          ))}
      </ul>
    </>
  );
}

type Given = Omit<ExportOptions, "target">;

function Fields({
  clip,
  loop,
  given,
  target,
  onChange,
}: {
  clip: Clip;
  loop: [number, number] | null;
  given: Given;
  target: Target;
  onChange: (more: Partial<Given>) => void;
}) {
  const { unit } = target;
  const known = clip.detail.unit !== null && clip.detail.unit !== undefined;
  return (
    <>
      <label>
        {w("label.unit")}
        <select
          class="field"
          value={given.unit}
          disabled={!known}
          title={known ? undefined : w("label.needsUnit")}
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
          disabled={!clip.detail.up}
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
          placeholder={number(clip.player.perSecond, 2)}
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

/** A sentence on the guesses that the height depends on. */
function guessOf(known: Schemas["Calibration"] | undefined): string {
  const guessed = [known?.height, known?.unit].find((one) => one?.origin === "guessed");
  return guessed ? w("help.heightGuessed", { reason: guessed.reason }) : "";
}

/** The body beside a ruler, as tall as it is in the file. unit: of the file, "" where it is not known. */
function Measured({ clip, given, unit }: { clip: Clip; given: Given; unit: string }) {
  const calibration = useAsync(
    (signal) =>
      get("/documents/{id}/calibration", { path: { id: clip.id }, query: { revision: clip.detail.revision }, signal }),
    [clip],
  ).value;
  const positions = clip.positions(clip.player.frame.peek());
  const now = calibration?.height.metres ?? null;
  const metres = given.height ?? now;
  const isKnown = metres !== null && now !== null;
  return (
    <figure class="export-figure">
      {positions && (
        <RuledFigure
          skeleton={clip.skeleton}
          positions={positions}
          unit={calibration?.unit.metres ?? clip.skeleton.metres}
          ruler={isKnown ? rulerOf(metres, unit in UNITS ? unit : "m") : null}
          metres={metres ?? 0}
          times={isKnown ? metres / now : 1}
        />
      )}
      <figcaption class="dim">
        {isKnown ? w("help.heightInFile", { metres: number(metres, 2) }) : w("help.heightUnknown")}{" "}
        {isKnown && given.height === null && guessOf(calibration)}
      </figcaption>
    </figure>
  );
}

function Lines({ id, options }: { id: string; options: ExportOptions }) {
  const lines = {
    Command: exportByCommand(id, options, location.origin),
    Curl: exportByCurl(id, options, location.origin, needsToken()),
  };
  return <ScriptLines lines={lines} />;
}
