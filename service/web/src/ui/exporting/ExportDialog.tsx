/** A clip exported for a program or in a format, in a size, at a rate, in place; its height in the file is drawn. */
import { useEffect, useState } from "preact/hooks";
import { fetched, get, type Schemas } from "../../api/client";
import { loadCharacters } from "../../state/clip/characters";
import type { Clip } from "../../state/clip/clip";
import { needsToken } from "../../state/session/me";
import { refuse } from "../../state/session/notes";
import { number, w } from "../../words";
import { Dialog } from "../Dialog";
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
import { ExportFields, START, TargetChoice, targetOf, targetsOf, type Given, type Known } from "./ExportFields";
import { RuledFigure } from "./RuledFigure";
import { saveBlob } from "./saveBlob";
import { ScriptLines } from "./ScriptLines";
import "../../styles/shared.css";

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
  const targets = targetsOf(clip.skeleton.view.markers ? "markers" : "bodies");
  const [key, setKey] = useState<string | null>(null);
  const [given, setGiven] = useState<Given>({ ...START, range });
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
          <TargetChoice
            targets={targets}
            chosen={chosen}
            onChoose={(next) => {
              setTold(null);
              setKey(next);
            }}
          />
          <ExportFields known={knownOf(clip)} loop={range} given={given} target={chosen} onChange={change} />
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

const knownOf = ({ detail, player }: Clip): Known => ({
  unit: detail.unit !== null && detail.unit !== undefined,
  up: Boolean(detail.up),
  rate: player.perSecond,
});

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
