/** A model of reaches: its examples, how well it fits, and the motion that sliders make with it. */
import { useEffect, useMemo } from "preact/hooks";
import { resultOf } from "../../api/results";
import { subject } from "../../state/session/shell";
import { lazy } from "../../ui/lazy";
import { offer } from "../../state/session/keys";
import { param, setParams } from "../../state/session/route";
import { Tabs } from "../../ui/Tabs";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import { Blend } from "./Blend";
import { Corrections } from "./corrections";
import { Examples } from "./Examples";
import { modelOf, type Model } from "./model";
import { speedsOf } from "./speeds";
import { Start } from "./Start";
import { b } from "./words";
import "../../styles/analyses.css";
import "../../styles/reach.css";

const Fit = lazy(async () => (await import("./Fit")).Fit); // with the library of its curves
const TABS = ["examples", "fit", "blend"] as const;

export function ReachPage({ id }: { id: string }) {
  useEffect(() => () => void (subject.value = null), []);
  return id ? <Opened id={id} /> : <Start />;
}

function Opened({ id }: { id: string }) {
  const result = useAsync((signal) => resultOf(id, signal), [id]);
  const found = result.value;
  useEffect(() => {
    if (found) subject.value = { text: found.name, detail: found.name };
  }, [found]);
  if (result.error || !found)
    return (
      <>
        <h1 class="unseen">{w("label.reach")}</h1>
        {result.error ? (
          <Trouble error={result.error} retry={result.again} />
        ) : (
          <div class="busy" role="presentation" />
        )}
      </>
    );
  if (found.analysis !== "reach" || !found.parts?.model)
    return (
      <div class="empty">
        <h1>{w("label.reach")}</h1>
        <p>
          {b("error.noModel")} <a href={`/results/${id}`}>{w("button.openResult")}</a>
        </p>
      </div>
    );
  return <Ready key={id} model={modelOf(found)} />;
}

function Ready({ model: made }: { model: Model }) {
  const model = useMemo(() => made, [made.id]);
  const corrections = useMemo(() => new Corrections(model), [model]);
  const speeds = useAsync((signal) => speedsOf(model.result, signal), [model]);
  const said = param("tab");
  const tab = TABS.find((one) => one === said) ?? "blend";
  const open = (id: string) => setParams({ tab: id }, true);
  useEffect(
    () =>
      offer("reach", [
        { id: "tabExamples", word: "label.reachExamples", keys: ["1"], run: () => open("examples") },
        { id: "tabFit", word: "label.reachFit", keys: ["2"], run: () => open("fit") },
        { id: "tabBlend", word: "label.reachBlend", keys: ["3"], run: () => open("blend") },
        {
          id: "undo",
          word: "button.undo",
          keys: ["Ctrl+Z"],
          run: () => corrections.undo(),
          when: () => corrections.steps.peek().length > 0,
        },
      ]),
    [corrections],
  );
  const count = corrections.count.value;
  return (
    <div class="reach">
      <h1 class="unseen">{`${w("label.reach")}: ${model.result.name}`}</h1>
      <div class="row reach-head">
        <Tabs
          label={w("label.reach")}
          open={tab}
          onOpen={open}
          tabs={TABS.map((one) => ({
            id: one,
            text:
              one === "fit"
                ? b("label.fitTab")
                : one === "examples" && count
                  ? `${b(`label.${one}`)} · ${b("label.corrections", { n: count })}`
                  : b(`label.${one}`),
          }))}
        />
        <a class="button quiet" href="/reach">
          {b("label.otherModels")}
        </a>
      </div>
      <div id={`panel-${tab}`} class="reach-tab" role="tabpanel" aria-labelledby={`tab-${tab}`}>
        {tab === "examples" ? (
          <Examples model={model} corrections={corrections} speeds={speeds.value} />
        ) : tab === "fit" ? (
          <Fit model={model} />
        ) : (
          <Blend model={model} speeds={speeds.value} />
        )}
      </div>
    </div>
  );
}
