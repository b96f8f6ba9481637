/** The clip's own bar: the draft and its saving, comparison, export. */
import { useState } from "preact/hooks";
import { ApiError, ask } from "../../api/client";
import type { Clip } from "../../state/clip/clip";
import { setParams } from "../../state/session/route";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { ShareDialog } from "../../ui/exporting/ShareDialog";
import { Trouble } from "../../ui/Trouble";
import { w } from "../../words";
import { clipActions } from "./actions";
import { CompareButton } from "./viewer/Compare";
import { ExportMenu } from "./ExportMenu";
import { OthersEdit, People } from "./People";
import { ConflictBanner } from "./ConflictBanner";
import { proposeClip, saveClip } from "./keys";
import { MessageField } from "./review/MessageField";
import { PendingProposals } from "./review/PendingProposals";
import { r } from "./words";
import { mustPropose } from "../../state/clip/review";
import { copyText, note, refuse } from "../../state/session/notes";

export function ClipBar({ clip, reload }: { clip: Clip; reload: () => void }) {
  const { detail } = clip;
  const [sharing, setSharing] = useState(false);
  const changed = clip.changed.value;
  const conflict = clip.trouble.value instanceof ApiError && [409, 412].includes(clip.trouble.value.status);
  const restore = async () => {
    try {
      const newest = await ask("get", "/documents/{id}", { path: { id: clip.id } });
      const made = await ask("post", "/documents/{id}/restore", {
        path: { id: clip.id },
        query: { revision: detail.revision },
        match: newest.revision,
      });
      note(w("label.restoredAs", { n: (made as { revision: number }).revision }));
      setParams({ rev: null });
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <>
      <div class="clip-bar row">
        <strong class="cut">{detail.name}</strong>
        {clip.pinned !== null ? (
          <>
            <span class="chip">{w("help.oldRevision")}</span>
            <button type="button" class="button primary" onClick={() => void restore()}>
              {w("button.restore")}
            </button>
            <button type="button" class="button" onClick={() => setParams({ rev: null })}>
              {w("button.openNewest")}
            </button>
          </>
        ) : changed ? (
          <>
            <span class="draft-words" role="status">
              {w("label.draft", { n: clip.draft.value.steps })}
            </span>
            <MessageField />
            {!mustPropose() && (
              <button
                type="button"
                class="button primary"
                disabled={clip.saving.value}
                onClick={() => void saveClip(clip, reload)}
              >
                {w("button.save")}
              </button>
            )}
            <button
              type="button"
              class={mustPropose() ? "button primary" : "button"}
              title={r("help.propose")}
              disabled={clip.saving.value}
              onClick={() => void proposeClip(clip)}
            >
              {r("button.propose")}
            </button>
            <button type="button" class="button quiet" onClick={() => clip.discard()}>
              {w("button.discard")}
            </button>
          </>
        ) : null}
        <span class="grow" />
        <PendingProposals />
        <People />
        <button
          type="button"
          class="button quiet icon"
          aria-label={w("button.undo")}
          title={`${w("button.undo")} (Ctrl+Z)`}
          disabled={!clip.canUndo && (detail.revision <= 1 || clip.pinned !== null)}
          onClick={() => {
            if (!clip.undo()) void clipActions.undoStored(clip, reload);
          }}
        >
          <Icon name="undo" />
        </button>
        <button
          type="button"
          class="button quiet icon"
          aria-label={w("button.redo")}
          title={`${w("button.redo")} (Ctrl+Shift+Z)`}
          disabled={!clip.canRedo}
          onClick={() => clip.redo()}
        >
          <Icon name="redo" />
        </button>
        {clip.frames > 0 && (
          <button
            type="button"
            class="button"
            title={w(clip.player.loop.value ? "help.motionsLikeHelp" : "help.posesLikeHelp")}
            onClick={() => clipActions.findSimilar(clip)}
          >
            {w("button.findSimilar")}
          </button>
        )}
        <CompareButton clip={clip} />
        <Menu
          label={w("button.share")}
          side="right"
          items={[
            { text: w("button.copyAddress"), run: () => void copyText(location.href, w("label.addressCopied")) },
            { text: w("button.shareLink"), run: () => setSharing(true) },
          ]}
        >
          {w("button.share")}
          <Icon name="down" />
        </Menu>
        <ExportMenu clip={clip} reload={reload} />
      </div>
      {clip.pinned === null && <OthersEdit />}
      {sharing && <ShareDialog ids={[clip.id]} onClose={() => setSharing(false)} />}
      {conflict ? (
        <ConflictBanner clip={clip} reload={reload} />
      ) : (
        <Trouble
          error={clip.trouble.value}
          retry={clip.trouble.value ? () => void saveClip(clip, reload) : undefined}
        />
      )}
    </>
  );
}
