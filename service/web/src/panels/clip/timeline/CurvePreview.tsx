/** A curve before and after an edit that is not made yet, with a choice of the curve. */
import { useMemo } from "preact/hooks";
import uPlot from "uplot";
import {
  curvesOfBone,
  keyOf,
  nameOf,
  pointsOf,
  replacedRanges,
  type CurveName,
} from "../../../motion/timeline/comparing";
import type { Clip } from "../../../state/clip/clip";
import { Plot, type Curve, type Zone } from "../../../ui/Plot";
import { w } from "../../../words";
import type { Made } from "./editFrames";

export function CurvePreview({
  clip,
  made,
  busy,
  chosen,
  choose,
}: {
  clip: Clip;
  /** The last answer of a dry run; while the next is on its way, the one before. */
  made: Made | undefined;
  busy: boolean;
  chosen: CurveName;
  choose: (next: CurveName) => void;
}) {
  const curve = made?.curves[0];
  const key = keyOf(chosen);
  const drawn = useMemo(() => {
    const curve = made?.curves[0];
    if (!curve) return null;
    const sides = [pointsOf(curve.before), pointsOf(curve.after, shiftOf(made))];
    const [x, before, after] = uPlot.join(sides.map(({ frames, values }): uPlot.AlignedData => [frames, values])) as [
      number[],
      (number | null)[],
      (number | null)[],
    ];
    const curves: Curve[] = [
      { name: w("label.curveBefore"), values: before, ink: "text3", width: 1 },
      { name: w("label.curveAfter"), values: after, ink: "accent" },
    ];
    const ranges = replacedRanges(made.replaced, nameOf(key));
    const zones = ranges.map(({ first, last }): Zone => ({ from: first - 0.5, to: last + 0.5, ink: "accent" }));
    return { x, curves, zones, empty: sides.every(({ values }) => values.every((value) => value === null)) };
  }, [made, key]);
  return (
    <section class="curve-preview" aria-busy={busy}>
      <label class="row">
        {w("label.curve")}
        <select
          class="field grow"
          aria-label={w("label.curve")}
          value={key}
          onChange={(event) => choose(nameOf(event.currentTarget.value))}
        >
          <Choices clip={clip} chosen={chosen} />
        </select>
      </label>
      <div class="curve-preview-plot">
        {drawn?.empty && <p class="dim">{w("help.curveEmpty", { name: curve?.name ?? "" })}</p>}
        {curve && drawn && !drawn.empty && (
          <Plot
            x={drawn.x}
            curves={drawn.curves}
            zones={drawn.zones}
            label={w("label.curvesCompared", { name: curve.name })}
            xLabel={w("label.frame")}
            yLabel={curve.unit || undefined}
            height={150}
          />
        )}
      </div>
      <p class="dim curve-preview-state" role="status">
        {busy ? w("label.computing") : ""}
      </p>
    </section>
  );
}

const shiftOf = (made: Made | undefined): number => (made?.first_kept ?? 1) - 1;

/** Curves by joint. A quantity that is shown elsewhere on the page stands by itself. */
function Choices({ clip, chosen }: { clip: Clip; chosen: CurveName }) {
  const groups = clip.skeleton.view.bones.map((bone) => ({ bone: bone.name, curves: curvesOfBone(bone) }));
  const listed = groups.some(({ curves }) => curves.some((one) => keyOf(one) === keyOf(chosen)));
  return (
    <>
      {!listed && <option value={keyOf(chosen)}>{chosen.name}</option>}
      {groups.map(({ bone, curves }) => (
        <optgroup key={bone} label={bone}>
          {curves.map((one) => (
            <option key={one.name} value={keyOf(one)}>
              {labelOf(one, bone)}
            </option>
          ))}
        </optgroup>
      ))}
    </>
  );
}

function labelOf({ kind, name }: CurveName, bone: string): string {
  if (kind === "column") return name;
  return `${bone}: ${w(name.startsWith("height:") ? "label.quantityHeight" : "label.quantitySpeed")}`;
}
