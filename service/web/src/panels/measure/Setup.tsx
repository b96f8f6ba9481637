/** Chooses clips, frame ranges, groups and measurements; the address has them all. */
import { useState } from "preact/hooks";
import { get } from "../../api/client";
import { startOf, textOf, type Asked as Chosen } from "../../motion/body/quantities";
import { param, setParams } from "../../state/session/route";
import { ClipSelection, type Member, type useMembers } from "../../ui/clips/ClipSelection";
import { MeasurementChoice } from "../../ui/clips/MeasurementChoice";
import { Icon } from "../../ui/icons";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import { quantityName } from "./names";
import { bothSides, FEET, GAIT, HANDS, writeQuantities, type Asked } from "./request";
import { m } from "./words";

const MOST_LABELS = 300;
const KEYS = ["clip", "label", "project", "person"] as const;
const PRESETS = [
  ["button.addGait", GAIT],
  ["button.addHands", HANDS],
  ["button.addFeet", FEET],
] as const;

export const add = (asked: Asked, more: readonly string[]): void =>
  setParams({ m: writeQuantities([...asked.quantities, ...more]), row: null });

export function Setup({ asked, members }: { asked: Asked; members: ReturnType<typeof useMembers> }) {
  return (
    <aside class="measure-setup" aria-label={m("label.setup")}>
      <h1>{w("label.measure")}</h1>
      <section class="measure-part" aria-label={m("label.measurements")}>
        <h2>{m("label.measurements")}</h2>
        <Measurements asked={asked} first={members.value?.[0]} />
      </section>
      <Ranges asked={asked} />
      <section class="measure-part" aria-label={m("label.clips")}>
        <h2>{m("label.clips")}</h2>
        <ClipSelection members={members} />
      </section>
    </aside>
  );
}

function Measurements({ asked, first }: { asked: Asked; first: Member | undefined }) {
  const body = useAsync(
    async (signal) => {
      if (!first) return null;
      const path = { id: first.id };
      const [skeleton, measured] = await Promise.all([
        get("/documents/{id}/skeleton", { path, signal }),
        get("/documents/{id}/measurements", { path, signal }),
      ]);
      return { bones: [...skeleton.centres, ...skeleton.bones.map((bone) => bone.name)], measured: measured.items };
    },
    [first?.id],
  );
  const bones = body.value?.bones ?? [];
  const [chosen, setChosen] = useState<Chosen>({ kind: "angle", argument: "left-knee-flexion" });
  const current = bones.length ? startOf(textOf(chosen), undefined, bones) : chosen;
  const text = textOf(current);
  const both = bothSides(text);
  return (
    <>
      {asked.quantities.length > 0 && (
        <ul class="measure-chips">
          {asked.quantities.map((one) => (
            <li key={one} class="chip">
              {quantityName(one)}
              <button
                type="button"
                class="button quiet icon dense"
                aria-label={m("button.remove", { name: quantityName(one) })}
                onClick={() => setParams({ m: writeQuantities(asked.quantities.filter((each) => each !== one)) })}
              >
                <Icon name="close" />
              </button>
            </li>
          ))}
        </ul>
      )}
      <div class="row wrap">
        {PRESETS.map(([word, quantities]) => (
          <button type="button" key={word} class="button dense" onClick={() => add(asked, quantities)}>
            {m(word)}
          </button>
        ))}
      </div>
      {bones.length > 0 && (
        <div class="row wrap measure-choice">
          <MeasurementChoice asked={current} bones={bones} measured={body.value?.measured ?? []} choose={setChosen} />
          <button type="button" class="button dense" onClick={() => add(asked, [text])}>
            {m("button.add")}
          </button>
          {both.length > 1 && (
            <button type="button" class="button dense" onClick={() => add(asked, both)}>
              {m("button.addBoth")}
            </button>
          )}
        </div>
      )}
    </>
  );
}

function Ranges({ asked }: { asked: Asked }) {
  const labels = useAsync((signal) => get("/motion-names", { signal }), []);
  const facets = useAsync((signal) => get("/facets", { signal }), []);
  const names = (labels.value?.items ?? []).map((one) => one.name).slice(0, MOST_LABELS);
  const label = asked.ranges.startsWith("label:") ? asked.ranges.slice("label:".length) : "";
  const properties = (facets.value?.properties ?? []).map((one) => one.name);
  const choose = (name: string, value: string) => setParams({ [name]: value || null, row: null });
  return (
    <div class="selection-fields">
      <label>
        {m("label.ranges")}
        <select class="field" value={asked.ranges} onChange={(event) => choose("ranges", event.currentTarget.value)}>
          <option value="">{m("label.whole")}</option>
          <option value="strides">{m("label.strides")}</option>
          <option value="query">{m("label.ofQuery")}</option>
          <optgroup label={m("label.labels")}>
            {[...new Set([...(label ? [label] : []), ...names])].map((name) => (
              <option key={name} value={`label:${name}`}>
                {name}
              </option>
            ))}
          </optgroup>
        </select>
      </label>
      {asked.ranges === "query" && (
        <label>
          {m("label.query")}
          <input
            class="field"
            value={param("q")}
            placeholder="//frame[motion_name = 'walk']"
            onChange={(event) => choose("q", event.currentTarget.value)}
          />
        </label>
      )}
      <label>
        {m("label.by")}
        <select class="field" value={asked.by} onChange={(event) => choose("by", event.currentTarget.value)}>
          <option value="">{m("label.side")}</option>
          {KEYS.map((key) => (
            <option key={key} value={key}>
              {m("label.sideAnd", { key: m(`label.${key}`) })}
            </option>
          ))}
          {[...new Set(properties)].map((name) => (
            <option key={name} value={`property:${name}`}>
              {m("label.sideAnd", { key: name })}
            </option>
          ))}
        </select>
      </label>
    </div>
  );
}
