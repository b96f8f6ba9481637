/** A child for an element: which of those that the DTD allows there, and what it must say. */
import { itemAt } from "../../../lists";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { address, fetched, get } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { withAdded, withDeleted, type Addition } from "../../../state/editing/draft";
import { addable, placeOf, readDtd, written, type Dtd } from "../../../state/editing/dtd";
import { refuse } from "../../../state/session/notes";
import type { Element } from "../../../state/editing/outline";
import { Dialog } from "../../../ui/Dialog";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { w } from "../../../words";

let known: Promise<Dtd> | null = null;
export const theDtd = (): Promise<Dtd> =>
  (known ??= fetch("/mcml.dtd").then(async (answer) => readDtd(await answer.text())));

const MOTION = "/mcml/motion";
const MOST = 1000; // children of an element of the head that are looked at

/** Delete an element, or let one that the draft deletes stay. */
export const deleteElement = (clip: Clip, node: Element): Promise<boolean> =>
  clip.tryChange((draft) => withDeleted(draft, node.address));

/** Put a copy of an element behind it. */
export async function duplicateElement(clip: Clip, node: Element): Promise<void> {
  try {
    const fragment = await (
      await fetched(
        address("/documents/{id}/elements", { id: clip.id }, { xpath: node.address, revision: clip.detail.revision }),
      )
    ).text();
    await clip.tryChange((draft) => withAdded(draft, node.address, { where: "after", fragment }));
  } catch (error) {
    refuse(error);
  }
}

/** Where a child goes: frames and what is in them find their place themselves. */
function target(
  dtd: Dtd,
  node: Element,
  siblings: readonly Element[],
  name: string,
  fragment: string,
): [string, Addition] {
  if (node.address.startsWith(MOTION) || !siblings.length) return [node.address, { where: "into", fragment }];
  const place = placeOf(
    dtd.get(node.name)!,
    siblings.map((one) => one.name),
    name,
  );
  return place < 0
    ? [itemAt(siblings, 0).address, { where: "before", fragment }]
    : [itemAt(siblings, place).address, { where: "after", fragment }];
}

export function AddElement({ clip, node, onClose }: { clip: Clip; node: Element; onClose: () => void }) {
  const around = useAsync(
    async (signal) => {
      const [dtd, page] = await Promise.all([
        theDtd(),
        get("/documents/{id}/children", {
          path: { id: clip.id },
          query: { address: node.address, limit: node.address === MOTION ? 2 : MOST, revision: clip.detail.revision },
          signal,
        }),
      ]);
      return { dtd, siblings: page.items };
    },
    [clip, node.address],
  );
  const [chosen, setChosen] = useState("");
  const [values, setValues] = useState<ReadonlyMap<string, string>>(new Map());
  const names = useMemo(() => {
    const { dtd, siblings } = around.value ?? {};
    const kind = dtd?.get(node.name);
    return kind
      ? addable(
          kind,
          siblings!.map((one) => one.name),
        )
      : [];
  }, [around.value]);
  useEffect(() => {
    if (names.length && !names.includes(chosen))
      setChosen(
        itemAt(names, names.length - 1) === "comment"
          ? (names.find((one) => one === "property") ?? itemAt(names, 0))
          : itemAt(names, 0),
      );
  }, [names]);
  const form = useRef<HTMLFormElement>(null);
  useEffect(() => form.current?.querySelector<HTMLElement>("select")?.focus(), [names.length > 0]);
  const kind = around.value?.dtd.get(chosen);
  const set = (name: string, value: string) => setValues(new Map(values).set(name, value));
  const required = kind
    ? [
        ...(kind.text ? [""] : []),
        ...kind.children.filter((one) => one.required).map((one) => one.name),
        ...kind.attributes.filter((one) => one.required).map((one) => `@${one.name}`),
      ]
    : [];
  const optional = kind?.attributes.filter((one) => !one.required) ?? [];
  const ready = required.every((name) => values.get(name)?.trim());
  const add = async () => {
    if (!kind || !around.value || !ready) return;
    const [at, addition] = target(around.value.dtd, node, around.value.siblings, chosen, written(kind, values));
    if (await clip.tryChange((draft) => withAdded(draft, at, addition))) onClose();
  };
  const field = (name: string, options?: string[]) => {
    const label = name === "" ? w("label.text") : name.replace("@", "");
    return (
      <label key={name} class="info-row">
        <span>{label}</span>
        {options ? (
          <select
            class="field"
            value={values.get(name) ?? ""}
            onChange={(event) => set(name, event.currentTarget.value)}
          >
            <option value="" />
            {options.map((one) => (
              <option key={one}>{one}</option>
            ))}
          </select>
        ) : (
          <input
            class="field"
            value={values.get(name) ?? ""}
            onInput={(event) => set(name, event.currentTarget.value)}
          />
        )}
      </label>
    );
  };
  return (
    <Dialog title={w("button.addTo", { name: node.name })} onClose={onClose}>
      <Trouble error={around.error} retry={around.again} />
      {around.value && !names.length && <p class="dim">{w("help.nothingToAdd")}</p>}
      {names.length > 0 && (
        <form
          ref={form}
          class="add-element"
          onSubmit={(event) => {
            event.preventDefault();
            void add();
          }}
        >
          <label class="info-row">
            <span>{w("label.element")}</span>
            <select
              class="field"
              value={chosen}
              onChange={(event) => {
                setChosen(event.currentTarget.value);
                setValues(new Map());
              }}
            >
              {names.map((one) => (
                <option key={one}>{one}</option>
              ))}
            </select>
          </label>
          {required.map((name) => field(name, kind?.attributes.find((one) => `@${one.name}` === name)?.values))}
          {optional.length > 0 && (
            <details>
              <summary class="dim">{w("label.optionalAttributes")}</summary>
              {optional.map((one) => field(`@${one.name}`, one.values))}
            </details>
          )}
          <p class="row">
            <span class="grow" />
            <button type="submit" class="button primary" disabled={!ready}>
              {w("button.add")}
            </button>
          </p>
        </form>
      )}
    </Dialog>
  );
}
