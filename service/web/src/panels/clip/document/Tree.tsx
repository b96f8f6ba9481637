/** The whole document as a tree. Values are changed in place; frames are gone to. */
import { entryOf, itemAt, numberAt } from "../../../lists";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Clip } from "../../../state/clip/clip";
import { replacedBy, withElement, withoutAdded } from "../../../state/editing/draft";
import { readWithin, sampleIn } from "../../../state/editing/fragment";
import { Outline, type Element, type Row } from "../../../state/editing/outline";
import { SIDE_TOKENS } from "../../../motion/body/skeleton";
import { Icon } from "../../../ui/icons";
import { Menu, type Item } from "../../../ui/Menu";
import { Trouble } from "../../../ui/Trouble";
import { VirtualList } from "../../../ui/VirtualList";
import { number, w } from "../../../words";
import { AddElement, deleteElement, duplicateElement } from "./AddElement";

const TALL = 24;
const SAMPLE = /^\/mcml(?:\[1\])?\/motion(?:\[1\])?\/frame\[(\d+)\]/;
const CHANNEL = /^([TR][xyz]|SF|residual)$/;

export function Tree({ clip }: { clip: Clip }) {
  const outline = useMemo(() => new Outline(clip.id, clip.detail.revision), [clip]);
  const [focus, setFocus] = useState(0);
  const [edited, setEdited] = useState<string | null>(null);
  const [seen, setSeen] = useState<number>();
  const [parent, setParent] = useState<Element | null>(null);
  void outline.version.value;
  void clip.draft.value;
  void clip.channels.arrived.value;
  const selected = clip.selection.value.bones;

  // What is selected elsewhere, at the frame that is looked at, is shown here.
  useEffect(() => {
    if (!selected.length || clip.player.playing.peek()) return;
    let alive = true;
    void outline.rowOfFrame(clip.player.frame.peek() + 1, itemAt(selected, 0)).then((row) => {
      if (alive && row > 0) {
        setSeen(row);
        setFocus(row);
      }
    });
    return () => {
      alive = false;
    };
  }, [outline, selected[0]]);

  const gotoFrame = async () => {
    const row = await outline.rowOfFrame(clip.player.frame.peek() + 1, null);
    if (row > 0) {
      setSeen(row);
      setFocus(row);
    }
  };
  const choose = (row: Row, index: number) => {
    setFocus(index);
    const node = row.node;
    if (!node) return;
    const frame = SAMPLE.exec(node.address);
    if (frame) {
      clip.player.pause();
      clip.player.seek(Number(frame[1]) - 1);
    }
    const bone = (node.name === "frame_bone" && node.attributes.name) || null;
    if (bone) clip.select([bone], row.attribute);
  };
  const focusRow = (index: number) => {
    const next = Math.max(0, Math.min(outline.rows - 1, index));
    setFocus(next);
    setSeen(next);
    requestAnimationFrame(() => document.querySelector<HTMLElement>(`.tree [data-row="${next}"]`)?.focus());
  };
  const editable = clip.pinned === null;
  /** An attribute goes at once; an element when the repository would let it go. */
  const remove = (row: Row) => {
    const node = row.node!;
    if (!editable) return;
    if (row.attribute)
      void clip.tryChange((draft) =>
        withElement(draft, { address: node.address, attributes: { [row.attribute!]: null } }),
      );
    else void deleteElement(clip, node);
  };
  const chosenRow = focus < outline.rows ? outline.row(focus) : null;
  const actions = (): Item[] => {
    const node = chosenRow?.node;
    if (!node || !editable) return [{ text: w("help.oldRevision"), disabled: true }];
    const removal = w(clip.draft.peek().elements.get(node.address)?.deleted ? "button.letStay" : "button.delete");
    return [
      { text: w("button.addChild"), detail: "Ins", icon: "plus", run: () => setParent(node) },
      { text: w("button.duplicate"), disabled: !!chosenRow.attribute, run: () => void duplicateElement(clip, node) },
      { text: removal, detail: "Del", icon: "trash", run: () => remove(chosenRow) },
    ];
  };
  const onKey = (event: KeyboardEvent) => {
    if ((event.target as HTMLElement).tagName === "INPUT") return;
    const row = outline.row(focus);
    const node = row.node;
    const opens = node && !row.attribute && !outline.isLeaf(node) && node.address !== "/mcml";
    switch (event.key) {
      case "ArrowDown":
        focusRow(focus + 1);
        break;
      case "ArrowUp":
        focusRow(focus - 1);
        break;
      case "Home":
        focusRow(0);
        break;
      case "End":
        focusRow(outline.rows - 1);
        break;
      case "ArrowRight":
        if (opens && !row.open) outline.toggle(node.address, true);
        else focusRow(focus + 1);
        break;
      case "ArrowLeft":
        if (opens && row.open) outline.toggle(node.address, false);
        else {
          let up = focus;
          while (up > 0 && outline.row(up).depth >= row.depth) up--;
          focusRow(up);
        }
        break;
      case "Insert":
        if (node && editable) setParent(node);
        break;
      case "Delete":
        if (node) remove(row);
        break;
      case "F2":
      case "Enter":
        if (row.attribute || node?.text) setEdited(keyOf(row));
        else if (opens) outline.toggle(node.address);
        choose(row, focus);
        break;
      default:
        return;
    }
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <div class="tree" onKeyDown={onKey}>
      <div class="tree-tools row">
        <span class="dim grow">{w("label.elements", { n: outline.rows })}</span>
        {chosenRow?.node && (
          <Menu label={w("label.element")} className="button quiet dense" side="right" items={actions}>
            {chosenRow.attribute ?? titleOf(chosenRow.node)}
            <Icon name="down" />
          </Menu>
        )}
        <button type="button" class="button quiet dense" onClick={() => void gotoFrame()}>
          {w("label.frame")} {number(clip.player.frame.value + 1)}
        </button>
      </div>
      <Trouble error={outline.trouble.value} />
      <VirtualList
        rows={outline.rows}
        height={TALL}
        label={w("label.tree")}
        role="tree"
        at={seen}
        render={(index) => {
          const row = outline.row(index);
          const node = row.node;
          if (!node)
            return (
              <div class="tree-row dim" style={{ paddingLeft: `${row.depth * 16 + 24}px` }}>
                …
              </div>
            );
          const opens = !row.attribute && !outline.isLeaf(node) && node.address !== "/mcml";
          const change = clip.draft.value.elements.get(node.address);
          const gone =
            replacedBy(clip.draft.value, node.address)?.owner.deleted ||
            (row.attribute !== null && change?.attributes[row.attribute] === null);
          const value = valueOf(clip, row);
          const bone = (node.name === "frame_bone" && node.attributes.name) || null;
          const side =
            bone !== null ? SIDE_TOKENS[numberAt(clip.skeleton.sides, clip.skeleton.byName.get(bone) ?? 0)] : null;
          return (
            <div
              class={`tree-row ${index === focus ? "focus" : ""} ${bone && selected.includes(bone) ? "chosen" : ""} ${gone ? "gone" : ""}`}
              role="treeitem"
              data-row={index}
              tabIndex={index === focus ? 0 : -1}
              aria-level={row.depth + 1}
              aria-setsize={row.siblings}
              aria-posinset={row.place + 1}
              aria-expanded={opens ? row.open : undefined}
              aria-selected={index === focus}
              style={{ paddingLeft: `${row.depth * 16 + 8}px` }}
              onClick={() => choose(row, index)}
              onContextMenu={(event) => {
                event.preventDefault();
                choose(row, index);
                requestAnimationFrame(() => document.querySelector<HTMLElement>(".tree-tools .menu > button")?.click());
              }}
              onDblClick={() => (row.attribute || node.text) && setEdited(keyOf(row))}
            >
              <span
                class="twist"
                onClick={(event) => {
                  if (opens) {
                    outline.toggle(node.address);
                    event.stopPropagation();
                  }
                }}
              >
                {opens && <Icon name={row.open ? "down" : "right"} />}
              </span>
              {side && !row.attribute && <span class="dot" style={{ background: `var(--${side})` }} />}
              <span class="cut">{row.attribute ?? titleOf(node)}</span>
              {row.attribute === null &&
                change?.added?.map((one, place) => {
                  const name = /<([\w.-]+)/.exec(one.fragment)?.[1] ?? "";
                  return (
                    <span key={place} class="chip added" title={one.fragment}>
                      {{ into: "↳", after: "↓", before: "↑" }[one.where]} {name}
                      <button
                        type="button"
                        tabIndex={-1}
                        aria-label={w("button.takeBack", { name })}
                        title={w("button.takeBack", { name })}
                        onClick={(event) => {
                          event.stopPropagation();
                          clip.change(withoutAdded(clip.draft.peek(), node.address, place));
                        }}
                      >
                        <Icon name="close" />
                      </button>
                    </span>
                  );
                })}
              {row.attribute === null && node.name === "motion" && (
                <span class="dim tail">{w("label.frames", { n: clip.frames })}</span>
              )}
              {edited === keyOf(row) ? (
                <ValueField
                  value={value.exact}
                  label={row.attribute ?? node.name}
                  onDone={(text) => {
                    setEdited(null);
                    if (text !== null && text !== value.exact) write(clip, row, text);
                    focusRow(index);
                  }}
                />
              ) : (
                (row.attribute || node.text) && (
                  <span class={`value tail cut ${value.changed ? "changed" : ""}`} title={value.exact}>
                    {value.shown}
                  </span>
                )
              )}
            </div>
          );
        }}
      />
      {parent && <AddElement clip={clip} node={parent} onClose={() => setParent(null)} />}
    </div>
  );
}

const keyOf = (row: Row): string => `${row.node?.address}@${row.attribute ?? ""}`;

/** What an element is called in the tree: its own name, or what names it. */
function titleOf(node: Element): string {
  if (node.name === "frame") return `frame ${node.attributes.id ?? ""}`;
  if (node.name === "frame_bone") return node.attributes.name ?? node.name;
  return node.name;
}

function trackOf(row: Row): { track: string; frame: number } | null {
  const frame = row.node && SAMPLE.exec(row.node.address);
  if (!frame || row.node!.name !== "frame_bone" || !row.attribute || !CHANNEL.test(row.attribute)) return null;
  return { track: `${row.node!.attributes.name}.${row.attribute}`, frame: Number(frame[1]) };
}

function valueOf(clip: Clip, row: Row): { shown: string; exact: string; changed: boolean } {
  const node = row.node!;
  const sample = trackOf(row);
  if (sample) {
    const text = replacedBy(clip.draft.value, node.address)?.owner.fragment;
    const drafted =
      clip.draft.value.samples.get(sample.track)?.get(sample.frame) ??
      (text === undefined ? undefined : (sampleIn(text, sample.track) ?? undefined));
    const exact = drafted === undefined ? entryOf(node.attributes, row.attribute!) : String(drafted);
    const rounded = Number(exact);
    return {
      exact,
      shown: Number.isFinite(rounded) ? String(Number(rounded.toFixed(4))) : exact,
      changed: drafted !== undefined,
    };
  }
  const inside = replacedBy(clip.draft.value, node.address);
  const text =
    inside?.owner.fragment === undefined ? null : readWithin(inside.owner.fragment, inside.steps, row.attribute);
  if (text !== null)
    return { exact: text, shown: text, changed: text !== (row.attribute ? node.attributes[row.attribute] : node.text) };
  const change = clip.draft.value.elements.get(node.address);
  const changed = row.attribute ? change?.attributes[row.attribute] : change?.text;
  const exact = changed ?? (row.attribute ? node.attributes[row.attribute] : node.text);
  return { exact: exact ?? "", shown: exact ?? "", changed: changed !== undefined };
}

function write(clip: Clip, row: Row, text: string): void {
  const sample = trackOf(row);
  if (sample) {
    const value = Number(text.replace(",", "."));
    if (Number.isFinite(value)) clip.setSamples(sample.track, [[sample.frame, value]]);
  } else if (row.attribute) clip.setElement({ address: row.node!.address, attributes: { [row.attribute]: text } });
  else clip.setElement({ address: row.node!.address, attributes: {}, text });
}

export function ValueField({
  value,
  label,
  onDone,
}: {
  value: string;
  label: string;
  onDone: (text: string | null) => void;
}) {
  const field = useRef<HTMLInputElement>(null);
  const over = useRef(false);
  useEffect(() => field.current?.select(), []);
  // Enter takes the field away, which also blurs it.
  const done = (text: string | null) => {
    if (over.current) return;
    over.current = true;
    onDone(text);
  };
  return (
    <input
      class="field value-field tail"
      aria-label={label}
      defaultValue={value}
      ref={field}
      onKeyDown={(event) => {
        if (event.key === "Enter") done(event.currentTarget.value);
        else if (event.key === "Escape") done(null);
        else return;
        event.stopPropagation();
        event.preventDefault();
      }}
      onBlur={(event) => done(event.currentTarget.value)}
      onClick={(event) => event.stopPropagation()}
      onDblClick={(event) => event.stopPropagation()}
    />
  );
}
