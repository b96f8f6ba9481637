/** The number that a measurement is compared with: a slider over the values of this library, and a field. */
import { get } from "../../../api/client";
import { useAsync } from "../../../ui/useAsync";
import { number } from "../../../words";
import { quantityOf, UNITS, type MeasureRow, type QuantityName } from "./question";
import { scaleOf, tidy } from "../rangeTable";
import { x } from "../words";

/** Ends of the slider where the library has no values. */
const USUAL: Record<QuantityName, [number, number]> = {
  speed: [0, 5],
  height: [0, 2.5],
  angle: [-30, 150],
  distance: [0, 2],
  above: [0, 1],
};

export function Threshold({
  row,
  project,
  onChange,
}: {
  row: MeasureRow;
  project: string;
  onChange: (value: number) => void;
}) {
  const quantity = quantityOf(row);
  const found = useAsync(
    async (signal) =>
      quantity ? get("/quantities/range", { query: { quantity, project: project || undefined }, signal }) : null,
    [quantity, project],
  );
  const { least, low, high, most } = found.value ?? {};
  const known =
    typeof least === "number" && typeof low === "number" && typeof high === "number" && typeof most === "number";
  const scale = scaleOf(known ? { least, low, high, most } : null, USUAL[row.quantity], row.value);
  const unit = UNITS[row.quantity];
  const label = x("label.threshold", { unit });
  return (
    <span class="row grow threshold">
      <input
        class="grow"
        type="range"
        aria-label={label}
        aria-valuetext={`${number(row.value, 3)} ${unit}`}
        title={known ? x("label.rangeOf", { low: number(low, 2), high: `${number(high, 2)} ${unit}` }) : undefined}
        {...scale}
        value={Number.isFinite(row.value) ? row.value : scale.min}
        onInput={(event) => onChange(tidy(event.currentTarget.valueAsNumber))}
      />
      <input
        class="field number"
        type="number"
        step="any"
        aria-label={label}
        value={Number.isFinite(row.value) ? row.value : ""}
        onInput={(event) => onChange(event.currentTarget.valueAsNumber)}
      />
      <span class="dim unit">{unit}</span>
    </span>
  );
}
