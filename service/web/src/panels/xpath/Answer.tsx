/** Answers that are no runs: one value, values, nodes; each with the document that it is of. */
import { useEffect, useState } from "preact/hooks";
import { copyText } from "../../state/session/notes";
import { get, type Schemas } from "../../api/client";
import { number, w } from "../../words";

/** A node, a value of a document, or one of several values. */
export type Item = Partial<Schemas["NodeItem"]> & { value?: string | number | boolean };

const LONG = 48; // characters, above which a value is text to be read
const MOST_SHOWN = 50_000; // of an element as XML

const textOf = (item: Item): string => String(item.value ?? "");

/** The only answer there is, large enough to be read at once. */
export function OneValue({ item }: { item: Item }) {
  const text = textOf(item);
  return (
    <div class="xpath-value" role="region" aria-label={w("label.value")} tabIndex={0}>
      <output class={text.length > LONG || !text ? "long" : ""}>
        {text ? <Shortened text={text} /> : <Nothing />}
      </output>
      <button type="button" class="button dense" onClick={() => void copyText(text, w("label.copied"))}>
        {w("button.copyValue")}
      </button>
    </div>
  );
}

/** What the columns of some items are. Nodes and values may stand in one answer. */
export function shapeOf(items: Item[]): "nodes" | "scalars" | "values" {
  if (items.some((one) => one.address !== undefined)) return "nodes";
  return items.some((one) => one.document !== undefined) ? "scalars" : "values";
}

export function ItemHead({ shape }: { shape: ReturnType<typeof shapeOf> }) {
  return (
    <div class={`run-row run-head of-${shape}`} aria-hidden="true">
      <span class="n">#</span>
      <span>{w("label.value")}</span>
      {shape === "nodes" && <span class="place">{w("label.addressWord")}</span>}
      {shape !== "values" && <span>{w("label.document")}</span>}
    </div>
  );
}

export function ItemCells({ item, row }: { item: Item; row: number }) {
  const text = textOf(item);
  return (
    <>
      <span class="n dim">{number(row + 1)}</span>
      <code class="cut">{text || <Nothing />}</code>
      {item.address !== undefined && (
        <span class="cut dim place" title={item.address}>
          {item.address}
        </span>
      )}
      {item.document !== undefined && (
        <span class="cut dim">
          <DocumentName id={item.document} />
        </span>
      )}
    </>
  );
}

/** All of a value whose row is too short for it. */
export function WholeValue({ item }: { item: Item }) {
  const text = textOf(item);
  if (text.length <= LONG) return null;
  return (
    <aside class="xpath-whole" aria-label={w("label.value")} tabIndex={0}>
      <div class="row">
        {item.document !== undefined && (
          <a class="cut" href={`/clips/${item.document}`}>
            <DocumentName id={item.document} />
          </a>
        )}
        <span class="grow" />
        <button type="button" class="button dense" onClick={() => void copyText(text, w("label.copied"))}>
          {w("button.copyValue")}
        </button>
      </div>
      {item.address !== undefined && <p class="dim">{item.address}</p>}
      <pre>
        <Shortened text={text} />
      </pre>
    </aside>
  );
}

const Shortened = ({ text }: { text: string }) => (
  <>{text.length > MOST_SHOWN ? `${text.slice(0, MOST_SHOWN)}…` : text}</>
);
const Nothing = () => <span class="dim">{w("label.emptyText")}</span>;

const named = new Map<string, Promise<string>>();

/** A document by its name, asked once, and only of rows in sight. */
function DocumentName({ id }: { id: string }) {
  const [name, setName] = useState("");
  useEffect(() => {
    let alive = true;
    // A row that is only scrolled past asks nothing.
    const timer = window.setTimeout(
      () => {
        if (!named.has(id))
          named.set(
            id,
            get("/documents/{id}", { path: { id } }).then(
              (one) => one.name,
              () => (named.delete(id), id),
            ),
          );
        void named.get(id)!.then((found) => alive && setName(found));
      },
      named.has(id) ? 0 : 100,
    );
    return () => {
      alive = false;
      window.clearTimeout(timer);
    };
  }, [id]);
  return <>{name || "…"}</>;
}
