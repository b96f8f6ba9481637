/** Ways out of a clip: files with and without options, the composer, another skeleton. */
import { useState } from "preact/hooks";
import type { Clip } from "../../state/clip/clip";
import { confirmFact } from "../../state/importing/uploads";
import { mayEdit } from "../../state/session/me";
import { go, setParams } from "../../state/session/route";
import { ExportDialog } from "../../ui/exporting/ExportDialog";
import { exportItems } from "../../ui/exporting/exports";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { w } from "../../words";
import { SkeletonsDialog } from "./SkeletonsDialog";
import { r } from "./words";

export function ExportMenu({ clip, reload }: { clip: Clip; reload: () => void }) {
  const {
    detail,
    skeleton: { view },
  } = clip;
  const [exporting, setExporting] = useState(false);
  const [solving, setSolving] = useState(false);
  const solvable = view.centres.some((name) => name.endsWith("left_up_leg"));
  return (
    <>
      <Menu
        label={w("button.exportWord")}
        side="right"
        items={() => [
          { text: w("button.exportOptions"), icon: "export", run: () => setExporting(true) },
          ...exportItems(
            {
              id: clip.id,
              markers: view.markers,
              original: detail.original,
              format: detail.format,
              revision: detail.revision,
              unit: detail.unit ?? null,
              likelyUnit: view.likely_unit,
              up: detail.up ?? null,
              likelyUp: view.likely_up,
              hasRate: Boolean(detail.seconds_per_frame),
              beside: detail.files.length > 1,
              centres: view.centres,
            },
            clip.pinned === null && mayEdit()
              ? {
                  accept: (fact) => void confirmFact([clip.id], fact).then((done) => done && reload()),
                  give: () => setParams({ tab: "info" }),
                }
              : {},
          ),
          { text: w("button.composeThese"), icon: "compose", run: () => go(`/compose?s=${clip.id}`) },
          { text: w("label.retarget"), icon: "retarget", run: () => go(`/retarget?from=${clip.id}`) },
          ...(view.markers && mayEdit()
            ? [
                {
                  text: r("button.makeSkeleton"),
                  icon: "retarget" as const,
                  disabled: !solvable,
                  detail: solvable ? undefined : r("label.noLandmarks"),
                  run: () => setSolving(true),
                },
              ]
            : []),
        ]}
      >
        {w("button.exportWord")}
        <Icon name="down" />
      </Menu>
      {solving && <SkeletonsDialog clip={clip} onClose={() => setSolving(false)} />}
      {exporting && (
        <ExportDialog
          clip={clip}
          range={clip.player.loop.peek() && [clip.player.range[0] + 1, clip.player.range[1] + 1]}
          onClose={() => setExporting(false)}
        />
      )}
    </>
  );
}
