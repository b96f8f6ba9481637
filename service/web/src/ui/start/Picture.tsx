/** One small picture for each page: what the page makes. Quiet, in the colours of the theme. */
import type { ComponentChildren } from "preact";
import { bodyOf, POSES, type Pose } from "./figure";

type Place = readonly [number, number];

/** faint: a body that is not the subject. */
function Figure({ pose, at, height, faint = false }: { pose: Pose; at: Place; height: number; faint?: boolean }) {
  const body = bodyOf(pose, at, height);
  return (
    <g class={faint ? "pic-figure faint" : "pic-figure"} stroke-width={height * 0.047}>
      {body.lines.map((one) => (
        <path key={one.path} class={`pic-${one.side}`} d={one.path} />
      ))}
      <circle class="pic-head" cx={body.head.x} cy={body.head.y} r={body.head.r} />
    </g>
  );
}

const Ground = ({ y, from = 28, to = 292 }: { y: number; from?: number; to?: number }) => (
  <path class="pic-ground" d={`M${from} ${y}H${to}`} />
);

const { stand, walk, pass, step, wave, groove, accent, sit } = POSES;

const Card = ({ at: [x, y], pose }: { at: Place; pose: Pose }) => (
  <>
    <rect class="pic-card" x={x} y={y} width="78" height="70" rx="7" />
    <Figure pose={pose} at={[x + 39, y + 37]} height={52} />
  </>
);

const Face = ({ at: [x, y], mouth, faint = false }: { at: Place; mouth: number; faint?: boolean }) => (
  <g class={faint ? "pic-face faint" : "pic-face"}>
    <ellipse cx={x} cy={y} rx="21" ry="25" />
    <circle class="pic-dot" cx={x - 8} cy={y - 5} r="2.4" />
    <circle class="pic-dot" cx={x + 8} cy={y - 5} r="2.4" />
    <path d={`M${x - 9} ${y + 10}Q${x} ${y + 10 + mouth} ${x + 9} ${y + 10}`} />
  </g>
);

/** The band of a standard deviation round a mean curve. */
const curveOf = (lift: number): [number, number][] =>
  Array.from({ length: 33 }, (_, index) => {
    const share = index / 32;
    const wave = Math.sin(share * Math.PI * 2 - 0.6) * 22 + Math.sin(share * Math.PI * 4) * 12;
    return [148 + share * 138, 92 - wave - lift];
  });
const through = (points: readonly (readonly [number, number])[]) =>
  points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");

const PICTURES = {
  library: (
    <>
      <Card at={[34, 16]} pose={walk} />
      <Card at={[121, 16]} pose={wave} />
      <Card at={[208, 16]} pose={groove} />
      <Card at={[34, 94]} pose={accent} />
      <Card at={[121, 94]} pose={step} />
      <Card at={[208, 94]} pose={stand} />
    </>
  ),
  xpath: (
    <>
      <rect class="pic-band" x="124" y="22" width="112" height="122" rx="8" />
      <Ground y={132} />
      <Figure pose={stand} at={[58, 90]} height={86} faint />
      <Figure pose={stand} at={[98, 90]} height={86} faint />
      <Figure pose={wave} at={[150, 90]} height={86} />
      <Figure pose={wave} at={[204, 90]} height={86} />
      <Figure pose={stand} at={[264, 90]} height={86} faint />
      <path class="pic-line" d="M126 156H234M126 151v10M234 151v10" />
    </>
  ),
  compose: (
    <>
      <Ground y={126} />
      <Figure pose={walk} at={[62, 84]} height={86} />
      <Figure pose={pass} at={[112, 84]} height={86} faint />
      <Figure pose={accent} at={[196, 84]} height={86} faint />
      <Figure pose={groove} at={[254, 84]} height={86} />
      <rect class="pic-piece one" x="28" y="142" width="140" height="16" rx="5" />
      <rect class="pic-piece two" x="150" y="142" width="142" height="16" rx="5" />
    </>
  ),
  retarget: (
    <>
      <Ground y={150} />
      <Figure pose={walk} at={[84, 117]} height={68} faint />
      <path class="pic-line pic-flow" d="M126 92C144 84 154 84 172 92" />
      <path class="pic-line" d="M166 85l7 7-9 4" />
      <Figure pose={walk} at={[226, 86]} height={132} />
    </>
  ),
  matching: (
    <>
      <path class="pic-ground" d="M40 158C92 176 116 128 160 134S250 168 284 106" />
      <path class="pic-line pic-flow" d="M40 158C92 176 116 128 160 134" />
      <Figure pose={walk} at={[76, 116]} height={72} faint />
      <Figure pose={step} at={[116, 102]} height={72} faint />
      <Figure pose={walk} at={[162, 92]} height={84} />
      <circle class="pic-goal" cx="284" cy="106" r="6" />
    </>
  ),
  reach: (
    <>
      <path class="pic-ground" d="M60 152H262M104 152v-42M86 110h44M90 110L80 52" />
      {[130, 112, 94].map((angle) => {
        const body = bodyOf({ ...sit, right: { ...sit.right, arm: [angle, angle - 6] } }, [104, 104], 112);
        const [x, y] = body.hands.right;
        return <circle key={angle} class="pic-goal faint" cx={x} cy={y} r="5" />;
      })}
      <Figure pose={{ ...sit, right: { ...sit.right, arm: [130, 124] } }} at={[104, 104]} height={112} faint />
      <Figure pose={{ ...sit, right: { ...sit.right, arm: [112, 106] } }} at={[104, 104]} height={112} />
      <path class="pic-line" d="M212 62h58M212 90h58M212 118h58" />
      <circle class="pic-goal" cx="228" cy="62" r="5" />
      <circle class="pic-goal" cx="256" cy="90" r="5" />
      <circle class="pic-goal" cx="240" cy="118" r="5" />
    </>
  ),
  dance: (
    <>
      <Ground y={122} />
      <Figure pose={accent} at={[82, 82]} height={84} faint />
      <Figure pose={groove} at={[160, 82]} height={84} />
      <Figure pose={wave} at={[238, 82]} height={84} faint />
      {Array.from({ length: 33 }, (_, index) => {
        const tall = 3 + 13 * Math.abs(Math.sin(index * 0.8)) * (index % 8 ? 0.7 : 1.25);
        const x = 32 + index * 8;
        return (
          <path
            key={index}
            class={index % 8 ? "pic-beat" : "pic-beat strong"}
            d={`M${x} ${152 - tall}V${152 + tall}`}
          />
        );
      })}
    </>
  ),
  faces: (
    <>
      <path class="pic-ground" d="M74 62L158 128 244 58M74 62L116 140M158 128l94 22M244 58l8 92M74 62L244 58" />
      <path class="pic-line pic-flow" d="M74 62L158 128 244 58" />
      <Face at={[74, 60]} mouth={0} />
      <Face at={[158, 124]} mouth={11} />
      <Face at={[244, 58]} mouth={-10} />
      <circle class="pic-dot" cx="116" cy="140" r="4" />
      <circle class="pic-dot" cx="252" cy="150" r="4" />
    </>
  ),
  measure: (
    <>
      <Ground y={136} from={24} to={122} />
      <Figure pose={walk} at={[74, 88]} height={100} />
      <path class="pic-ground" d="M140 24V148H292" />
      <path class="pic-area" d={`M${through(curveOf(11))}L${through(curveOf(-11).reverse())}Z`} />
      <path class="pic-line" d={`M${through(curveOf(0))}`} />
      <circle class="pic-goal" cx="228" cy="34" r="4.5" />
    </>
  ),
} satisfies Record<string, ComponentChildren>;

export type PictureName = keyof typeof PICTURES;

export const Picture = ({ name }: { name: PictureName }) => (
  <svg class="picture" viewBox="0 0 320 180" aria-hidden="true">
    {PICTURES[name]}
  </svg>
);
