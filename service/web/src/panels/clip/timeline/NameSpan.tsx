/** Name a stretch, with completion from the vocabulary; its frames as numbers; splitting and deleting. */
import { itemAt } from "../../../lists";
import { useLayoutEffect, useRef, useState } from "preact/hooks";
import type { Clip } from "../../../state/clip/clip";
import { agreed, loadVocabulary, namesLike } from "../../../state/library/vocabulary";
import { nameColour } from "../../../motion/timeline/colours";
import { w } from "../../../words";
import { clipActions, naming } from "../actions";

export function NameSpan({ clip, left }: { clip: Clip; left: number }) {
  const { span, fresh } = naming.value!;
  const [name, setName] = useState(span.name);
  const [first, setFirst] = useState(span.first);
  const [last, setLast] = useState(span.last);
  const [at, setAt] = useState(0);
  const box = useRef<HTMLFormElement>(null);
  // Before the next key: what is typed is the name, and no shortcut.
  useLayoutEffect(() => {
    void loadVocabulary();
    const field = box.current!.querySelector("input")!;
    field.focus();
    field.select();
  }, []);
  const names = namesLike(name.trim(), 7);
  const here = clip.player.frame.value + 1;
  const splits = span.first < here && span.last >= here;
  const close = () => (naming.value = null);
  const done = (chosen = name.trim()) => {
    if (!chosen) return;
    const next = {
      ...span,
      name: chosen,
      first: Math.max(1, Math.min(first, last)),
      last: Math.min(clip.frames, Math.max(first, last)),
    };
    const others = clip.labels.peek().filter((one) => one.id !== span.id);
    clip.setLabels([...others, next].sort((a, b) => a.first - b.first));
    close();
  };
  return (
    <form
      ref={box}
      class="name-span"
      style={{ left: `${left}px` }}
      aria-label={w("label.spanName")}
      onSubmit={(event) => {
        event.preventDefault();
        done();
      }}
      onKeyDown={(event) => {
        if (event.key === "Escape") {
          close();
          event.stopPropagation();
        }
        if (event.isComposing || (event.target as Element).tagName !== "INPUT") return;
        if (event.key === "ArrowDown" && names.length) {
          setAt((at + 1) % names.length);
          setName(itemAt(names, (at + 1) % names.length));
          event.preventDefault();
        }
      }}
    >
      <input
        class="field"
        role="combobox"
        aria-expanded={names.length > 0}
        aria-controls="span-names"
        aria-label={w("label.spanName")}
        placeholder={w("label.spanName")}
        value={name}
        autocomplete="off"
        onInput={(event) => {
          setName(event.currentTarget.value);
          setAt(-1);
        }}
      />
      <span class="row">
        <label class="dim">
          {w("label.spanFrom")}{" "}
          <input
            class="field number"
            type="number"
            min={1}
            max={clip.frames}
            value={first}
            onInput={(event) => setFirst(Number(event.currentTarget.value))}
          />
        </label>
        <label class="dim">
          {w("label.spanTo")}{" "}
          <input
            class="field number"
            type="number"
            min={1}
            max={clip.frames}
            value={last}
            onInput={(event) => setLast(Number(event.currentTarget.value))}
          />
        </label>
        <span class="grow" />
        {!fresh && (
          <button
            type="button"
            class="button dense"
            disabled={!splits}
            title={`${w("button.spanSplit")} (S)`}
            onClick={() => {
              clipActions.splitSpan(clip, span.id);
              close();
            }}
          >
            {w("button.split")}
          </button>
        )}
        {!fresh && (
          <button
            type="button"
            class="button dense"
            onClick={() => {
              clip.setLabels(clip.labels.peek().filter((one) => one.id !== span.id));
              close();
            }}
          >
            {w("button.delete")}
          </button>
        )}
        <button
          type="button"
          class="button dense"
          title={w("help.motionsLikeHelp")}
          onClick={() => clipActions.findSimilar(clip, { first: Math.min(first, last), last: Math.max(first, last) })}
        >
          {w("button.findSimilar")}
        </button>
        <button type="submit" class="button dense primary" disabled={!name.trim()}>
          {w(fresh ? "button.add" : "button.apply")}
        </button>
      </span>
      <ul id="span-names" role="listbox" aria-label={w("label.motionName")}>
        {names.map((one) => (
          <li
            key={one}
            role="option"
            aria-selected={one === name}
            onPointerDown={(event) => {
              event.preventDefault();
              done(one);
            }}
          >
            <span class="swatch" style={{ background: nameColour(one) }} />
            {one}
            <span class="dim cut">{agreed.value.find((word) => word.name === one)?.description}</span>
          </li>
        ))}
      </ul>
    </form>
  );
}
