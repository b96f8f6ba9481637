/** A form made of a JSON schema: parameters of any analysis, with their help; those after the first are folded away. */
import { useState } from "preact/hooks";
import { w } from "../../words";
import { fieldsOf, textOf, valueOf, type Field, type Schema } from "./schema";

export type Values = Record<string, unknown>;

/** values: what differs from the defaults. shown: how many fields stand open. leave: fields that something else sets. */
export function SchemaForm({
  schema,
  values,
  onChange,
  shown = 6,
  leave = [],
}: {
  schema: Schema;
  values: Values;
  onChange: (values: Values) => void;
  shown?: number;
  leave?: string[];
}) {
  const fields = fieldsOf(schema).filter((one) => !leave.includes(one.name));
  const first = fields.filter((one, at) => at < shown || one.required || values[one.name] !== undefined);
  const rest = fields.filter((one) => !first.includes(one));
  const set = (name: string, value: unknown) => {
    const next = { ...values };
    if (value === undefined) delete next[name];
    else next[name] = value;
    onChange(next);
  };
  const row = (field: Field) => (
    <Row key={field.name} field={field} value={values[field.name]} onChange={(value) => set(field.name, value)} />
  );
  return (
    <div class="schema-form">
      {first.map(row)}
      {rest.length > 0 && (
        <details>
          <summary>{w("label.moreOptions", { n: rest.length })}</summary>
          {rest.map(row)}
        </details>
      )}
    </div>
  );
}

function Row({ field, value, onChange }: { field: Field; value: unknown; onChange: (value: unknown) => void }) {
  const [fault, setFault] = useState("");
  const [text, setText] = useState<string | null>(null);
  const id = `field-${field.name}`;
  const about = { id, "aria-describedby": `${id}-help`, "aria-invalid": fault ? ("true" as const) : undefined };
  const take = (written: string) => {
    setText(written);
    try {
      onChange(valueOf(field, written));
      setFault("");
    } catch (error) {
      setFault(faultOf(field, (error as Error).message));
    }
  };
  const now = text ?? textOf(field, value);
  return (
    <div class="schema-field">
      <label for={id}>
        {field.title}
        {field.required && " *"}
      </label>
      {field.kind === "truth" ? (
        <input
          type="checkbox"
          {...about}
          checked={Boolean(value ?? field.initial)}
          onChange={(event) =>
            onChange(event.currentTarget.checked === field.initial ? undefined : event.currentTarget.checked)
          }
        />
      ) : field.kind === "choice" ? (
        <select
          class="field"
          {...about}
          value={String(value ?? field.initial ?? "")}
          onChange={(event) =>
            onChange(
              event.currentTarget.value === String(field.initial ?? "")
                ? undefined
                : valueOf(field, event.currentTarget.value),
            )
          }
        >
          {field.initial === null && <option value="">–</option>}
          {field.options.map((one) => (
            <option key={one} value={String(one)}>
              {one}
            </option>
          ))}
        </select>
      ) : field.kind === "choices" ? (
        <span class="row wrap" role="group" aria-label={field.title}>
          {field.options.map((one) => {
            const chosen = (value ?? field.initial ?? []) as unknown[];
            return (
              <label key={one} class="row">
                <input
                  type="checkbox"
                  checked={chosen.includes(one)}
                  onChange={(event) =>
                    onChange(event.currentTarget.checked ? [...chosen, one] : chosen.filter((other) => other !== one))
                  }
                />
                {one}
              </label>
            );
          })}
        </span>
      ) : field.kind === "json" ? (
        <textarea
          class="field code"
          rows={1}
          {...about}
          placeholder={textOf(field, field.initial)}
          value={now}
          onInput={(event) => take(event.currentTarget.value)}
        />
      ) : (
        <input
          class="field"
          {...about}
          inputMode={field.kind === "number" ? "decimal" : undefined}
          placeholder={textOf(field, field.initial)}
          value={now}
          onInput={(event) => take(event.currentTarget.value)}
        />
      )}
      <p class={fault ? "fault" : "dim"} id={`${id}-help`}>
        {fault || field.help}
      </p>
    </div>
  );
}

function faultOf(field: Field, fault: string): string {
  if (fault === "range")
    return w("error.outOfRange", { least: String(field.least ?? "–∞"), most: String(field.most ?? "∞") });
  return w(fault === "json" ? "error.noJson" : field.whole ? "error.noWhole" : "error.noNumber");
}
