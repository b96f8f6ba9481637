/** A clip's body, still, on which a joint is picked. Lists of joints beside it do the same by keys. */
import { itemAt, numberAt } from "../../../lists";
import { signal } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import { motionOf, type Motion } from "../../../motion/loading/source";
import { MotionView, type Actor } from "../../../ui/playing/MotionView";
import { x } from "../words";

/** joints: that are marked. onPick: told the name of a joint. */
export function Figure({
  document,
  joints,
  onPick,
}: {
  document: string;
  joints: readonly string[];
  onPick: (joint: string) => void;
}) {
  const [motion, setMotion] = useState<Motion | null>(null);
  const selected = useMemo(() => signal<number[]>([]), []);
  useEffect(() => {
    let alive = true;
    motionOf(document).then(
      (found) => alive && setMotion(found),
      () => alive && setMotion(null), // Without the body the lists of joints say the same.
    );
    return () => {
      alive = false;
    };
  }, [document]);
  const marked = joints.map((name) => motion?.skeleton.byName.get(name) ?? -1).filter((point) => point >= 0);
  if (marked.join() !== selected.peek().join()) selected.value = marked;
  const actors = useMemo<Actor[]>(() => (motion ? [actorOf(motion)] : []), [motion]);
  if (!motion) return <div class="builder-figure" />;
  return (
    <div class="builder-figure">
      <MotionView
        actors={actors}
        selected={selected}
        label={x("label.body")}
        onPick={(_, point) => {
          const { bones, tips } = motion.skeleton.view;
          const joint =
            point < bones.length
              ? point
              : numberAt(
                  tips.map((one) => one.bone),
                  point - bones.length,
                );
          onPick(itemAt(bones, joint).name);
        }}
      />
    </div>
  );
}

/** The body in the middle of its clip, on the spot. */
function actorOf({ skeleton, blocks, frames, perSecond }: Motion): Actor {
  const frame = Math.floor(frames / 2);
  blocks.want(frame, 1, perSecond);
  const positions = () => {
    blocks.arrived.value;
    return blocks.frame(frame);
  };
  return { skeleton, positions, inPlace: true };
}
