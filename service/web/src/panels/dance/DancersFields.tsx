/** How many dance, how they dance together, and how far apart; fields show where they matter. */
import { param, setParams } from "../../state/session/route";
import { NumberField } from "../../ui/forms/NumberField";
import { d } from "./words";

const MODES = ["unison", "canon", "free"] as const;
const MOST_DANCERS = 6;
const USUAL_SPACING = 1.2;
const write = (name: string, value: number | null) => setParams({ [name]: value === null ? null : String(value) });

export function DancersFields() {
  const count = Number(param("dancers")) || 1;
  const mode = param("mode") || "unison";
  return (
    <>
      <label class="row">
        {d("label.dancers")}
        <NumberField
          least={1}
          most={MOST_DANCERS}
          step={1}
          value={count}
          onChange={(value) => write("dancers", value === 1 ? null : value)}
        />
      </label>
      {count > 1 && (
        <>
          <label class="row" title={d("help.modeHelp")}>
            {d("label.mode")}
            <select class="field" value={mode} onChange={(event) => setParams({ mode: event.currentTarget.value })}>
              {MODES.map((one) => (
                <option key={one} value={one}>
                  {d(one === "free" ? "label.ownPaths" : `label.${one}`)}
                </option>
              ))}
            </select>
          </label>
          {mode === "canon" && (
            <label class="row">
              {d("label.delay")}
              <NumberField
                least={1}
                most={8}
                step={1}
                value={Number(param("delay")) || 1}
                onChange={(value) => write("delay", value)}
              />
            </label>
          )}
          <label class="row" title={d("help.spacingHelp")}>
            {d("label.spacing")}
            <NumberField
              least={0.5}
              most={10}
              step={0.1}
              value={Number(param("spacing")) || USUAL_SPACING}
              onChange={(value) => write("spacing", value)}
            />
          </label>
        </>
      )}
    </>
  );
}
