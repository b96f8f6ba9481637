/** The scope of a query and the form of its answer; queries kept and asked before. */
import { get } from "../../api/client";
import { asked } from "../../state/library/queries";
import { param, setParams } from "../../state/session/route";
import { kept } from "../../state/session/settings";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import { SavedQueries } from "./SavedQueries";
import { x } from "./words";

/** Whether the builder is open; on narrow screens the answer needs its room. */
export const building = kept("builder", matchMedia("(min-width: 900px)").matches);

/** onAsk: the scope or the form changed. */
export function AskBar({
  text,
  onAsk,
  onChoose,
}: {
  text: string;
  onAsk: () => void;
  onChoose: (query: string) => void;
}) {
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  const as = param("as") === "nodes" ? "json" : "runs";
  const project = param("project");
  const per = param("per") === "document";
  const guesses = param("guesses") !== "no";
  return (
    <div class="xpath-bar row wrap">
      <label class="row">
        <span class="dim">{w("label.scope")}</span>
        <select
          class="field"
          value={project}
          onChange={(event) => {
            setParams({ project: event.currentTarget.value || null });
            onAsk();
          }}
        >
          <option value="">{w("label.wholeLibrary")}</option>
          {(projects.value?.items ?? []).map((one) => (
            <option key={one} value={one}>
              {one}
            </option>
          ))}
        </select>
      </label>
      <button
        type="button"
        class="button"
        aria-pressed={per}
        title={w("help.perDocumentHelp")}
        aria-description={w("help.perDocumentHelp")}
        onClick={() => {
          setParams({ per: per ? null : "document" });
          onAsk();
        }}
      >
        {w("label.perDocument")}
      </button>
      <div class="segments" role="group" aria-label={w("label.answerAs")}>
        <button
          type="button"
          aria-pressed={as === "runs"}
          onClick={() => {
            setParams({ as: null });
            onAsk();
          }}
        >
          {w("label.runs")}
        </button>
        <button
          type="button"
          aria-pressed={as === "json"}
          onClick={() => {
            setParams({ as: "nodes" });
            onAsk();
          }}
        >
          {w("label.nodes")}
        </button>
      </div>
      <button
        type="button"
        class="button"
        aria-pressed={!guesses}
        title={x("help.withoutGuesses")}
        onClick={() => {
          setParams({ guesses: guesses ? "no" : null });
          onAsk();
        }}
      >
        {x("label.withoutGuesses")}
      </button>
      <button
        type="button"
        class="button"
        aria-pressed={building.value}
        onClick={() => (building.value = !building.value)}
      >
        {w("label.builder")}
      </button>
      <span class="grow" />
      <SavedQueries text={text} onChoose={onChoose} />
      <Menu
        label={w("label.queryHistory")}
        className="button quiet"
        side="right"
        items={asked.value
          .slice(0, 20)
          .map((one) => ({ text: one.length > 70 ? `${one.slice(0, 70)}…` : one, run: () => onChoose(one) }))}
      >
        {w("label.queryHistory")}
        <Icon name="down" />
      </Menu>
    </div>
  );
}
