/** The passport with its corrections, properties, provenance, lines for scripts. */
import { useState } from "preact/hooks";
import { ask } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { needsToken } from "../../../state/session/me";
import { copyText, refuse } from "../../../state/session/notes";
import { Icon } from "../../../ui/icons";
import { useTurns } from "../../../ui/useTurns";
import { duration, number, w, when } from "../../../words";

const UNITS = ["mm", "cm", "m", "inch"];
const AXES = ["Y", "Z", "X"];

export function Info({ clip, reload }: { clip: Clip; reload: () => void }) {
  const { detail, skeleton } = clip;
  const [property, setProperty] = useState({ name: "", value: "", unit: "" });
  const inTurn = useTurns<number>();
  const change = async (body: object) => {
    try {
      await inTurn(
        async (match = detail.revision) =>
          (await ask("patch", "/documents/{id}", { path: { id: clip.id }, body: body as never, match })).revision,
      );
      reload();
    } catch (error) {
      refuse(error);
    }
  };
  const locked = clip.pinned !== null;
  const text = (label: string, value: string, name: string) => (
    <label class="info-row">
      <span>{label}</span>
      <input
        class="field"
        value={value}
        disabled={locked}
        onChange={(event) => void change({ [name]: event.currentTarget.value })}
      />
    </label>
  );
  const fact = (
    label: string,
    value: string | null | undefined,
    likely: string | null | undefined,
    name: string,
    options: string[],
  ) => (
    <div class="info-row">
      <span>{label}</span>
      <span class="row">
        <select
          class="field"
          aria-label={label}
          disabled={locked}
          value={value ?? ""}
          onChange={(event) => void change({ [name]: event.currentTarget.value })}
        >
          <option value="" disabled>
            {w("label.unknown")}
          </option>
          {[...new Set([...options, ...(value ? [value] : [])])].map((one) => (
            <option key={one} value={one}>
              {one}
            </option>
          ))}
        </select>
        {!value && likely && options.includes(likely) && (
          <button type="button" class="button dense" disabled={locked} onClick={() => void change({ [name]: likely })}>
            {w("button.confirmAs", { value: likely })}
          </button>
        )}
      </span>
    </div>
  );
  const base = location.origin;
  const lines = [
    `curl ${needsToken() ? '-H "Authorization: Bearer $MCML_TOKEN" ' : ""}${base}/api/v1/documents/${clip.id}/export?format=bvh -o "${detail.name}.bvh"`,
    `mcml export ${clip.id} --format bvh --server ${base}`,
    needsToken()
      ? `import mcml, os; mcml.open("${base}", token=os.environ["MCML_TOKEN"]).document("${clip.id}")`
      : `import mcml; mcml.open("${base}").document("${clip.id}")`,
  ];
  const mapped = detail.bones.filter((bone) => bone.mapped).length;
  return (
    <div class="info">
      {text(w("label.name"), detail.name, "name")}
      {text(w("label.project"), detail.project, "project")}
      <label class="info-row">
        <span>{w("label.description")}</span>
        <textarea
          class="field"
          rows={2}
          value={detail.description}
          disabled={locked}
          onChange={(event) => void change({ description: event.currentTarget.value })}
        />
      </label>
      {fact(w("label.unit"), detail.unit, skeleton.view.likely_unit, "unit", UNITS)}
      {fact(w("label.up"), detail.up, skeleton.view.likely_up, "up", AXES)}
      <div class="info-row">
        <span>{w("label.rateWord")}</span>
        <span class="row">
          <input
            class="field number"
            type="number"
            min="0"
            step="any"
            aria-label={w("label.frameRate")}
            placeholder="120"
            disabled={locked}
            value={detail.seconds_per_frame ? Number((1 / detail.seconds_per_frame).toFixed(4)) : ""}
            onChange={(event) => {
              const hertz = Number(event.currentTarget.value);
              if (hertz > 0) void change({ frame_time: String(Number((1 / hertz).toPrecision(12))) });
            }}
          />{" "}
          Hz {skeleton.view.frame_time && <span class="dim">{skeleton.view.frame_time} s</span>}
        </span>
      </div>
      <div class="info-row">
        <span>{w("label.length")}</span>
        <span>
          {w("label.frames", { n: detail.frames })}, {duration(detail.duration)}
        </span>
      </div>
      <div class="info-row">
        <span>{w("label.joints")}</span>
        <span>
          {skeleton.view.markers ? number(detail.bones.length) : w("label.mapped", { mapped, n: detail.bones.length })}
        </span>
      </div>
      <h3>{w("label.properties")}</h3>
      <table aria-label={w("label.properties")}>
        <tbody>
          {detail.properties.map((one) => (
            <tr key={one.name}>
              <td>{one.name}</td>
              <td class="n">
                {one.value} <span class="dim">{one.unit}</span>
              </td>
              <td>
                <button
                  type="button"
                  class="button quiet icon dense"
                  aria-label={`${w("button.remove")} ${one.name}`}
                  disabled={locked}
                  onClick={() => void change({ properties: detail.properties.filter((other) => other !== one) })}
                >
                  <Icon name="close" />
                </button>
              </td>
            </tr>
          ))}
        </tbody>
      </table>
      <form
        class="row"
        onSubmit={(event) => {
          event.preventDefault();
          if (property.name)
            void change({ properties: [...detail.properties.filter((one) => one.name !== property.name), property] });
        }}
      >
        {(["name", "value", "unit"] as const).map((one) => (
          <input
            key={one}
            class="field grow"
            aria-label={w(`label.${one}`)}
            placeholder={w(`label.${one}`)}
            value={property[one]}
            disabled={locked}
            onInput={(event) => setProperty({ ...property, [one]: event.currentTarget.value })}
          />
        ))}
        <button
          type="submit"
          class="button icon"
          aria-label={w("button.addProperty")}
          disabled={locked || !property.name}
        >
          <Icon name="plus" />
        </button>
      </form>
      <h3>{w("label.provenance")}</h3>
      <div class="info-row">
        <span>{w("label.format")}</span>
        <span>{detail.format}</span>
      </div>
      <div class="info-row">
        <span>{w("label.original")}</span>
        <span>
          {detail.files.map((one) => (
            <span key={one.part}>
              {one.name} <span class="dim">{number(one.bytes)} B</span>
              <br />
            </span>
          ))}
        </span>
      </div>
      <div class="info-row">
        <span>{w("label.created")}</span>
        <span>{when(detail.created)}</span>
      </div>
      <CommandLines lines={lines} />
    </div>
  );
}

/** Lines of a shell that read the clip, each to be copied. */
const CommandLines = ({ lines }: { lines: string[] }) => (
  <>
    <h3>{w("label.commandLines")}</h3>
    {needsToken() && <p class="dim">{w("help.linesToken")}</p>}
    {lines.map((line) => (
      <div key={line} class="row code-line">
        <code class="grow" tabIndex={0}>
          {line}
        </code>
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("button.copy")}
          onClick={() => void copyText(line, w("label.copied"))}
        >
          <Icon name="list" />
        </button>
      </div>
    ))}
  </>
);
