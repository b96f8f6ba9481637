/** The bars of the dance in order: which stand there, and which alone may. */
import { rowsOf, type Result } from "../../api/results";
import { readAllowed, writeAllowed } from "../../motion/dance/dancing";
import { param, setParams } from "../../state/session/route";
import { number } from "../../words";
import { USUAL_BARS, type Bench } from "./bench";
import { d } from "./words";

const MOST = 128;
interface Step {
  position: number;
  node: number;
  document: string;
  bar: number;
  start: number;
  natural: boolean | null;
  distance: number | null;
}

export function PathStrip({ bench, made }: { bench: Bench; made?: Result }) {
  const allowed = readAllowed(param("allow"));
  const start = Number(param("start")) || 0;
  const result = bench.dry.value ?? made;
  const steps = result ? rowsOf<Step>(result.parts.path) : [];
  const count = Math.min(MOST, Math.max(steps.length, Math.min(Number(param("bars")) || USUAL_BARS, MOST)));
  const position = bench.position.value;
  const write = (bars: string) => {
    const next = readAllowed(writeAllowed(allowed));
    const numbers = bars
      .split(/[\s,.]+/)
      .map(Number)
      .filter((one) => Number.isInteger(one) && one > 0);
    if (numbers.length) next.set(position, numbers);
    else next.delete(position);
    setParams({ allow: writeAllowed(next) || null });
  };
  return (
    <div class="bench-path" role="group" aria-label={d("label.path")}>
      <div class="row wrap">
        <strong>{d("label.path")}</strong>
        <span class="dim grow cut">
          {position ? d("help.allowHelp", { n: position }) : start ? d("label.startsWith", { n: start }) : ""}
        </span>
        {position > 0 && (
          <label class="row">
            {d("label.allowField", { n: position })}
            <input
              class="field bench-allow"
              key={`${position} ${param("allow")}`}
              defaultValue={(allowed.get(position) ?? []).join(" ")}
              placeholder={d("label.anyBar")}
              onChange={(event) => write(event.currentTarget.value)}
            />
          </label>
        )}
        {position > 0 && (allowed.get(position)?.length ?? 0) === 1 && position === 1 && (
          <button
            type="button"
            class="button dense"
            onClick={() =>
              setParams({
                start: String(allowed.get(1)![0]),
                allow: writeAllowed(new Map([...allowed].filter(([key]) => key !== 1))) || null,
              })
            }
          >
            {d("button.startHere")}
          </button>
        )}
        {(allowed.size > 0 || start > 0) && (
          <button
            type="button"
            class="button dense"
            onClick={() => {
              setParams({ allow: null, start: null });
              bench.position.value = 0;
            }}
          >
            {d("button.clearPath")}
          </button>
        )}
      </div>
      <ol>
        {Array.from({ length: count }, (_, at) => {
          const step = steps[at];
          const wanted = allowed.get(at + 1) ?? (at === 0 && start ? [start] : undefined);
          const clip = step ? bench.documents.indexOf(step.document) : -1;
          const text = step ? String(step.node) : wanted ? wanted.join(" ") : "·";
          return (
            <li key={at}>
              <button
                type="button"
                class={`${wanted ? "wanted" : ""} ${step?.natural === false ? "jump" : ""}`}
                aria-pressed={position === at + 1}
                style={clip >= 0 ? { borderBottomColor: `var(--name${clip % 8})` } : undefined}
                aria-label={`${d("label.position", { n: at + 1 })}: ${step ? d("label.barWord", { n: step.node }) : wanted ? wanted.join(", ") : d("label.free")}`}
                title={step?.distance ? `${d("label.distance")} ${number(step.distance, 3)}` : undefined}
                onClick={() => {
                  bench.position.value = position === at + 1 ? 0 : at + 1;
                }}
              >
                {text}
              </button>
            </li>
          );
        })}
      </ol>
    </div>
  );
}
