/** Ctrl+K: pages, commands, clips, motion names, a time of the open clip, XPath. */
import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { get, type Schemas } from "../api/client";
import { commands } from "../state/session/keys";
import { loadVocabulary, namesLike } from "../state/library/vocabulary";
import { go } from "../state/session/route";
import { paletteOpen, timeJump } from "../state/session/shell";
import { Icon, type IconName } from "../ui/icons";
import { useAsync } from "../ui/useAsync";
import { duration, w } from "../words";

interface Found {
  key: string;
  icon: IconName;
  text: string;
  detail?: string;
  run: () => void;
}
const MOST = 8;

/** What the words lead to: XPath, a time, clips, motion names, commands. */
function foundFor(words: string, clips: Schemas["Card"][], names: string[]): Found[] {
  const found: Found[] = [];
  if (words.startsWith("//"))
    found.push({
      key: "xpath",
      icon: "xpath",
      text: words,
      detail: w("label.xpath"),
      run: () => go(`/xpath?q=${encodeURIComponent(words)}&run=1`),
    });
  if (words.startsWith(":") && timeJump.value)
    found.push({ key: "time", icon: "play", text: words, run: () => timeJump.value!(words.slice(1)) });
  for (const one of clips) {
    found.push({
      key: one.id,
      icon: "library",
      text: one.name,
      detail: [one.project, duration(one.duration)].filter(Boolean).join(" · "),
      run: () => go(`/clips/${one.id}`),
    });
  }
  for (const name of names) {
    found.push({
      key: `#${name}`,
      icon: "label",
      text: name,
      detail: w("label.motionName"),
      run: () => go(`/library?motion_name=${encodeURIComponent(name)}`),
    });
  }
  return [...found, ...commandsLike(words.replace(/^>/, "").toLowerCase())];
}

const commandsLike = (sought: string): Found[] =>
  commands()
    .filter((one) => one.id !== "palette" && w(one.word).toLowerCase().includes(sought) && (one.when?.() ?? true))
    .map((one) => ({ key: `>${one.id}`, icon: "right", text: w(one.word), detail: one.keys[0], run: one.run }));

export function Palette() {
  const [text, setText] = useState(paletteOpen.value ?? "");
  const [at, setAt] = useState(0);
  const box = useRef<HTMLDialogElement>(null);
  // Before the next letter is typed.
  useLayoutEffect(() => {
    box.current?.showModal();
  }, []);
  const words = text.trim();
  const plain = words && !/^(>|:|\/\/)/.test(words) ? words.replace(/^#/, "") : "";
  const clips = useAsync(
    async (signal) => {
      if (!plain) return { clips: [], names: [] as string[] };
      const [clips] = await Promise.all([
        words.startsWith("#") ? null : get("/documents", { query: { q: plain, limit: MOST }, signal }),
        loadVocabulary(),
      ]);
      return { clips: clips?.items ?? [], names: namesLike(plain, MOST) };
    },
    [plain, words.startsWith("#")],
  );
  const found = foundFor(words, clips.value?.clips ?? [], clips.value?.names ?? []);
  const place = Math.min(at, found.length - 1);
  const close = () => (paletteOpen.value = null);
  const onKey = (event: KeyboardEvent) => {
    if (event.isComposing) return;
    if (event.key === "ArrowDown") setAt((place + 1) % found.length);
    else if (event.key === "ArrowUp") setAt((place - 1 + found.length) % found.length);
    else if (event.key === "Enter" && found[place]) {
      close();
      found[place].run();
    } else return;
    event.preventDefault();
  };
  return (
    <dialog
      ref={box}
      class="palette"
      aria-label={w("label.palette")}
      onClose={close}
      onClick={(event) => event.target === box.current && close()}
    >
      <input
        class="field"
        role="combobox"
        aria-expanded={found.length > 0}
        aria-controls="palette-list"
        aria-activedescendant={found[place] && `palette-${place}`}
        aria-label={w("label.palette")}
        placeholder={w("label.searchAll")}
        value={text}
        onInput={(event) => {
          setText(event.currentTarget.value);
          setAt(0);
        }}
        onKeyDown={onKey}
        autoFocus
      />
      <ul id="palette-list" role="listbox" hidden={!found.length} aria-label={w("label.palette")}>
        {found.slice(0, 40).map((one, index) => (
          <li
            key={one.key}
            id={`palette-${index}`}
            role="option"
            aria-selected={index === place}
            onPointerMove={() => setAt(index)}
            onClick={() => {
              close();
              one.run();
            }}
          >
            <Icon name={one.icon} />
            <span class="grow cut">{one.text}</span>
            {one.detail && <span class="dim">{one.detail}</span>}
          </li>
        ))}
      </ul>
      {/* Beside the list: a listbox holds options alone. */}
      <p class="dim palette-none" role="status">
        {found.length ? "" : clips.busy ? w("label.loading") : w("help.nothingFound")}
      </p>
    </dialog>
  );
}
