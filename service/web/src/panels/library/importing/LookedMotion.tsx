/** The motion of a file that is not stored. */
import { useMemo } from "preact/hooks";
import { numbersOf, wholeOf, type Told } from "../../../motion/loading/preview";
import { WholeMotion } from "../../../ui/playing/WholeMotion";
import { w } from "../../../words";

export function LookedMotion({ told }: { told: Told }) {
  const motion = useMemo(() => wholeOf(told, numbersOf(told)), [told]);
  return <WholeMotion motion={motion} label={w("label.previewWord")} className="looked-motion" />;
}
