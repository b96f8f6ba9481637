/** What can be done with a result: each operation by the form of its schema, its answer as values or as motion. */
import { useMemo, useState } from "preact/hooks";
import type { Schemas } from "../../api/client";
import { makeMotion, applyResult, type Done, type Made } from "../../api/results";
import { wholeOf } from "../../motion/loading/preview";
import { SchemaForm, type Values } from "../../ui/forms/SchemaForm";
import type { Schema } from "../../ui/forms/schema";
import { Trouble } from "../../ui/Trouble";
import { WholeMotion } from "../../ui/playing/WholeMotion";
import { ApiError } from "../../api/client";
import { a } from "./words";

type Answer = Done<unknown> & Partial<Made<unknown>>;

export function Operations({ id, info, names }: { id: string; info: Schemas["AnalysisInfo"]; names: string[] }) {
  return (
    <aside class="result-operations" aria-label={a("label.operations")}>
      <h2>{a("label.operations")}</h2>
      {names.map(
        (name) =>
          info.operations[name] && (
            <details key={name}>
              <summary>{info.operations[name].description}</summary>
              <One id={id} name={name} schema={info.operations[name].parameters as Schema} />
            </details>
          ),
      )}
    </aside>
  );
}

function One({ id, name, schema }: { id: string; name: string; schema: Schema }) {
  const [values, setValues] = useState<Values>({});
  const [save, setSave] = useState(false);
  const [clip, setClip] = useState("");
  const [answer, setAnswer] = useState<Answer | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const run = async () => {
    setBusy(true);
    setError(null);
    const saving = { save, name: clip || undefined };
    try {
      setAnswer(
        await makeMotion(id, name, values, saving).catch((refused) => {
          // Most operations make no motion: their answer is values alone.
          if (refused instanceof ApiError && refused.status === 404) return applyResult(id, name, values, saving);
          throw refused;
        }),
      );
    } catch (refused) {
      setError(refused);
    } finally {
      setBusy(false);
    }
  };
  return (
    <form
      class="operation"
      onSubmit={(event) => {
        event.preventDefault();
        void run();
      }}
    >
      <SchemaForm schema={schema} values={values} onChange={setValues} />
      <label class="row">
        <input type="checkbox" checked={save} onChange={(event) => setSave(event.currentTarget.checked)} />
        {a("button.saveClip")}
      </label>
      {save && (
        <label>
          {a("label.clipName")}
          <input class="field" value={clip} onInput={(event) => setClip(event.currentTarget.value)} />
        </label>
      )}
      <button type="submit" class="button" disabled={busy}>
        {a("button.apply")}
      </button>
      <Trouble error={error} />
      {answer && (
        <div role="status">
          {answer.document && (
            <p>
              <a href={`/clips/${answer.document}`}>{a("label.storedAs")}</a>
            </p>
          )}
          {answer.result && (
            <p>
              <a href={`/results/${answer.result}`}>{a("label.keptAs")}</a>
            </p>
          )}
          {answer.motion && <Moving made={answer as Made<unknown>} />}
          <pre class="code answer" tabIndex={0}>
            {JSON.stringify(answer.value, null, 1).slice(0, 4000)}
          </pre>
        </div>
      )}
    </form>
  );
}

function Moving({ made }: { made: Made<unknown> }) {
  const motion = useMemo(() => wholeOf(made.motion, made.positions), [made]);
  return <WholeMotion motion={motion} label={a("label.playIt")} className="part-motion" />;
}
