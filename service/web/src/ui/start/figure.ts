/** Bodies of small pictures: limbs as lines, from the angles of a pose. */

/** Degrees from straight down, towards the right of the picture: [upper, lower] of limbs. */
export interface Pose {
  trunk: number;
  left: { arm: [number, number]; leg: [number, number] };
  right: { arm: [number, number]; leg: [number, number] };
}

export interface Line {
  side: "left" | "right" | "centre";
  path: string;
}
export interface Body {
  lines: Line[];
  head: { x: number; y: number; r: number };
  hands: { left: Point; right: Point };
}
type Point = readonly [number, number];

/** Lengths of a body of height 1. */
const [TRUNK, NECK, HEAD, ARM, LEG] = [0.29, 0.1, 0.062, [0.165, 0.155], [0.24, 0.235]] as const;

const from = ([x, y]: Point, angle: number, length: number): Point => {
  const turn = (angle * Math.PI) / 180;
  return [x + Math.sin(turn) * length, y + Math.cos(turn) * length];
};
const line = (points: readonly Point[]): string =>
  `M${points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}`;
const limb = (
  start: Point,
  [upper, lower]: [number, number],
  [first, second]: readonly [number, number],
): [Point, Point, Point] => {
  const middle = from(start, upper, first);
  return [start, middle, from(middle, lower, second)];
};

/** hips: place of the hips in the picture. height: of the body, in units of the picture. */
export function bodyOf(pose: Pose, hips: Point, height: number): Body {
  const up = 180 - pose.trunk;
  const shoulders = from(hips, up, TRUNK * height);
  const head = from(shoulders, up, NECK * height);
  const arm = ARM.map((length) => length * height) as [number, number];
  const leg = LEG.map((length) => length * height) as [number, number];
  const limbs = (["left", "right"] as const).map((side) => ({
    side,
    arm: limb(shoulders, pose[side].arm, arm),
    leg: limb(hips, pose[side].leg, leg),
  }));
  const [left, right] = limbs as [(typeof limbs)[0], (typeof limbs)[0]];
  return {
    lines: [
      { side: "left", path: line(left.leg) },
      { side: "left", path: line(left.arm) },
      { side: "centre", path: line([hips, shoulders]) },
      { side: "right", path: line(right.leg) },
      { side: "right", path: line(right.arm) },
    ],
    head: { x: head[0], y: head[1], r: HEAD * height },
    hands: { left: left.arm[2], right: right.arm[2] },
  };
}

const pose = (
  trunk: number,
  left: [number, number, number, number],
  right: [number, number, number, number],
): Pose => ({
  trunk,
  left: { arm: [left[0], left[1]], leg: [left[2], left[3]] },
  right: { arm: [right[0], right[1]], leg: [right[2], right[3]] },
});

export const POSES = {
  stand: pose(0, [-14, -8, -5, -4], [14, 8, 5, 4]),
  walk: pose(4, [-30, -12, 28, 8], [26, 46, -16, -42]),
  pass: pose(3, [-6, 8, 6, 2], [6, 26, 20, -34]),
  step: pose(4, [28, 46, -16, -42], [-30, -12, 28, 8]),
  wave: pose(0, [-14, -8, -5, -4], [118, 168, 5, 4]),
  groove: pose(-7, [-122, -160, -24, -6], [104, 150, 46, -22]),
  accent: pose(8, [-70, -128, -38, -14], [140, 172, 26, 4]),
  sit: pose(-6, [20, 60, 84, 2], [96, 88, 82, 8]),
} as const;
