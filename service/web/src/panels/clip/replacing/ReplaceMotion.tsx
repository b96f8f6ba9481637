/** A new file for a clip: what would change is shown first; frames that differ are replaced as one revision. */
import { Fragment } from "preact";
import { useEffect, useState } from "preact/hooks";
import { ApiError, address, fetched, type Schemas } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { mustPropose } from "../../../state/clip/review";
import { dropOnto } from "../../../state/importing/drop";
import { note, refuse } from "../../../state/session/notes";
import { Dialog } from "../../../ui/Dialog";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { number, w } from "../../../words";
import { undoSaved } from "../keys";
import { r } from "../words";
import { replacing } from "./asked";

type Replaced = Schemas["FileReplaced"];

/** Names of joints that are listed; the others are in the tooltip. */
const SHOWN = 6;

interface Asked {
  files: readonly File[];
  /** Whether skeleton, unit and frame rate may be replaced too. */
  skeleton: boolean;
  dryRun: boolean;
}

async function send(clip: Clip, { files, skeleton, dryRun }: Asked, signal?: AbortSignal): Promise<Replaced> {
  const form = new FormData();
  for (const file of files) form.append("file", file, file.name);
  form.append("replace_skeleton", String(skeleton));
  form.append("dry_run", String(dryRun));
  const answer = await fetched(address("/documents/{id}/file", { id: clip.id }), {
    method: "PUT",
    headers: { "if-match": `"${clip.detail.revision}"` },
    body: form,
    signal,
  });
  return (await answer.json()) as Replaced;
}

/** Asks about files that are chosen for an open clip, or dropped on its page, while it may be changed. */
export function ReplaceMotion({ clip, reload }: { clip: Clip; reload: () => void }) {
  const open = clip.pinned === null && !mustPropose() && !clip.changed.value;
  useEffect(() => {
    if (!open) return;
    const take = (files: readonly File[]) => void (replacing.value = { id: clip.id, files });
    dropOnto.value = { title: r("label.dropReplace"), help: r("help.dropReplace", { name: clip.detail.name }), take };
    return () => void (dropOnto.value = null);
  }, [open, clip]);
  const asked = replacing.value;
  if (asked?.id !== clip.id || !asked.files.length) return null;
  return (
    <ReplaceDialog clip={clip} files={asked.files} reload={reload} onClose={() => void (replacing.value = null)} />
  );
}

function ReplaceDialog({
  clip,
  files,
  reload,
  onClose,
}: {
  clip: Clip;
  files: readonly File[];
  reload: () => void;
  onClose: () => void;
}) {
  const [busy, setBusy] = useState(false);
  const [skeleton, setSkeleton] = useState(false);
  const found = useAsync((signal) => send(clip, { files, skeleton, dryRun: true }, signal), [files, skeleton]);
  const other = found.error instanceof ApiError && found.error.problem.code === "other-skeleton";
  const differs = Boolean(found.value?.first);
  const replace = async () => {
    setBusy(true);
    try {
      const made = await send(clip, { files, skeleton, dryRun: false });
      onClose();
      note(r("label.motionReplaced", { n: made.frames }), {
        action: { text: w("button.undo"), run: () => void undoSaved(clip, made.revision, reload) },
      });
      reload();
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <Dialog title={r("button.replaceMotion")} onClose={onClose}>
      <div class="skeletons">
        <p class="dim">{files.map((file) => file.name).join(", ")}</p>
        <Trouble error={found.error} />
        {(other || skeleton) && (
          <label class="row check">
            <input type="checkbox" checked={skeleton} onChange={(event) => setSkeleton(event.currentTarget.checked)} />
            {r("label.replaceSkeleton")}
          </label>
        )}
        {!found.value && !found.error && <div class="busy" />}
        {found.value && (differs ? <Difference of={found.value} /> : <p>{r("help.nothingDiffers")}</p>)}
        <div class="row export-done">
          <div class="grow" />
          <button type="button" class="button primary" disabled={busy || !differs} onClick={() => void replace()}>
            {busy ? w("label.loading") : r("button.replaceFrames")}
          </button>
        </div>
      </div>
    </Dialog>
  );
}

function Difference({ of }: { of: Replaced }) {
  return (
    <dl class="facts">
      <dt>{w("label.framesWord")}</dt>
      <dd>
        {of.frames === of.frames_before ? number(of.frames) : `${number(of.frames_before)} → ${number(of.frames)}`}
      </dd>
      <dt>{r("label.framesDiffer")}</dt>
      <dd>{`${number(of.first ?? 0)}–${number(of.last ?? 0)}`}</dd>
      {of.skeleton ? (
        <SkeletonDifference of={of.skeleton} />
      ) : (
        <>
          <dt>{r("label.jointsDiffer")}</dt>
          <dd>{number(of.joints.length)}</dd>
        </>
      )}
      {of.largest && (
        <>
          <dt>{r("label.largestChange")}</dt>
          <dd>
            {`${of.largest.bone}.${of.largest.channel}: ${number(of.largest.before, 2)} → ${number(of.largest.after, 2)} `}
            <span class="dim">{r("label.atFrame", { n: of.largest.frame })}</span>
          </dd>
        </>
      )}
    </dl>
  );
}

/** Joints by what happens to them, and the frame rate where it changes. */
function SkeletonDifference({ of }: { of: Schemas["SkeletonReplaced"] }) {
  const joints = [
    ["label.jointsAdded", of.added],
    ["label.jointsRemoved", of.removed],
    ["label.jointsChanged", of.changed],
  ] as const;
  const [before, after] = [of.rate_before, of.rate];
  return (
    <>
      {joints.map(
        ([word, names]) =>
          names.length > 0 && (
            <Fragment key={word}>
              <dt>{r(word)}</dt>
              <dd title={names.join(", ")}>{`${number(names.length)}: ${shorten(names)}`}</dd>
            </Fragment>
          ),
      )}
      {before !== after && (
        <>
          <dt>{w("label.frameRate")}</dt>
          <dd>{`${rateOf(before)} → ${rateOf(after)}`}</dd>
        </>
      )}
    </>
  );
}

const shorten = (names: readonly string[]) => names.slice(0, SHOWN).join(", ") + (names.length > SHOWN ? " …" : "");

const rateOf = (rate: number | null) => (rate === null ? w("label.unknown") : number(rate, 2));
