/** One box: words, motion names that become chips, or XPath from its first slash. */
import { useEffect, useState } from "preact/hooks";
import { filter } from "../../state/library/library";
import { setParams } from "../../state/session/route";
import { loadVocabulary, namesLike } from "../../state/library/vocabulary";
import { nameColour } from "../../motion/timeline/colours";
import { Icon } from "../../ui/icons";
import { w } from "../../words";

const WAIT = 200; // ms after the last letter

export function SearchBox() {
  const asked = (filter.value.xpath ?? filter.value.q ?? "") as string;
  const [text, setText] = useState(asked);
  const [open, setOpen] = useState(false);
  const [at, setAt] = useState(-1);
  useEffect(() => void loadVocabulary(), []);
  useEffect(() => setText(asked), [asked]);
  useEffect(() => {
    if (text === asked) return;
    const timer = setTimeout(
      () => {
        const isXpath = text.trimStart().startsWith("/");
        setParams({ q: isXpath ? null : text.trim() || null, xpath: isXpath ? text.trim() : null });
      },
      text.trimStart().startsWith("/") ? WAIT * 3 : WAIT,
    );
    return () => clearTimeout(timer);
  }, [text]);
  const isXpath = text.trimStart().startsWith("/");
  const names = open && text.trim() && !isXpath ? namesLike(text.trim(), 6) : [];
  const choose = (name: string) => {
    setText("");
    setOpen(false);
    setParams({ q: null, motion_name: name }, true);
  };
  const name = filter.value.motion_name as string | undefined;
  return (
    <div
      class="search"
      onFocusOut={(event) => {
        if (!event.currentTarget.contains(event.relatedTarget as Node)) setOpen(false);
      }}
    >
      <Icon name={isXpath ? "xpath" : "search"} />
      {name && (
        <button type="button" class="chip" title={w("button.remove")} onClick={() => setParams({ motion_name: null })}>
          <span class="swatch" style={{ background: nameColour(name) }} />
          {name}
          <Icon name="close" />
        </button>
      )}
      <input
        class={isXpath ? "code" : ""}
        data-search
        type="search"
        list={undefined}
        role="combobox"
        aria-expanded={names.length > 0}
        aria-controls="search-names"
        aria-label={w("label.search")}
        placeholder={w("label.searchAll")}
        value={text}
        onInput={(event) => {
          setText(event.currentTarget.value);
          setOpen(true);
          setAt(-1);
        }}
        onKeyDown={(event) => {
          if (event.isComposing) return;
          if (event.key === "ArrowDown" && names.length) {
            setAt((at + 1) % names.length);
            event.preventDefault();
          } else if (event.key === "ArrowUp" && names.length) {
            setAt((at - 1 + names.length) % names.length);
            event.preventDefault();
          } else if (event.key === "Enter" && names[at]) choose(names[at]);
          else if (event.key === "Escape") {
            if (names.length) setOpen(false);
            else if (text) setText("");
            else event.currentTarget.blur();
            event.stopPropagation();
          } else if (event.key === "Backspace" && !text && name) setParams({ motion_name: null });
        }}
      />
      {names.length > 0 && (
        <ul id="search-names" class="menu-list left" role="listbox" aria-label={w("label.motionName")}>
          {names.map((one, index) => (
            <li
              key={one}
              role="option"
              aria-selected={index === at}
              class={index === at ? "at" : ""}
              onPointerDown={(event) => {
                event.preventDefault();
                choose(one);
              }}
            >
              <span class="swatch" style={{ background: nameColour(one) }} />
              {one}
            </li>
          ))}
        </ul>
      )}
    </div>
  );
}
