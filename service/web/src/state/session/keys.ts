/** Keys: a table of commands with their keys, found by `event.code` so that they work under any layout. */
import { signal } from "@preact/signals";
import { singleKeys } from "./settings";
import type { Words } from "../../words";

export interface Command {
  id: string;
  /** Its name in the words' table. */
  word: keyof Words;
  /** Such as "Space", "Shift+Right", "Ctrl+K", "G then L". */
  keys: string[];
  run: () => void;
  /** Whether it can run now. */
  when?: () => boolean;
}

/** Commands by whoever offers them: the shell, and the page that is open. */
const offered = signal<Map<string, Command[]>>(new Map());

export const commands = (): Command[] => [...offered.value.values()].flat();

/** The commands of one owner. */
export const commandsOf = (owner: string): Command[] => offered.value.get(owner) ?? [];

/** Offer commands until the returned function is called. */
export function offer(owner: string, list: Command[]): () => void {
  offered.value = new Map(offered.peek()).set(owner, list);
  return () => {
    const rest = new Map(offered.peek());
    if (rest.get(owner) === list) rest.delete(owner);
    offered.value = rest;
  };
}

const NAMES: Record<string, string> = {
  Space: "Space",
  ArrowLeft: "Left",
  ArrowRight: "Right",
  ArrowUp: "Up",
  ArrowDown: "Down",
  Slash: "/",
  Comma: ",",
  Period: ".",
  BracketLeft: "[",
  BracketRight: "]",
  Backslash: "\\",
  Escape: "Esc",
  Enter: "Enter",
  Delete: "Del",
  Backspace: "Backspace",
  Home: "Home",
  End: "End",
  PageUp: "PgUp",
  PageDown: "PgDn",
  Semicolon: ";",
  Quote: "'",
  F2: "F2",
  Minus: "-",
  Equal: "=",
};

/** What was pressed, as in `Command.keys`. */
export function chord(event: KeyboardEvent): string {
  const code = event.code;
  const name =
    NAMES[code] ?? (code.startsWith("Key") ? code.slice(3) : code.startsWith("Digit") ? code.slice(5) : code);
  if (event.key === "?") return "?";
  const held = [event.ctrlKey || event.metaKey ? "Ctrl" : "", event.altKey ? "Alt" : "", event.shiftKey ? "Shift" : ""];
  return [...held.filter(Boolean), name].join("+");
}

function isTyping(target: EventTarget | null): boolean {
  const element = (target instanceof Element && target.shadowRoot?.activeElement) || target;
  if (!(element instanceof HTMLElement)) return false;
  if (element.isContentEditable) return true;
  return (
    /^(TEXTAREA|SELECT)$/.test(element.tagName) ||
    (element instanceof HTMLInputElement && !/^(checkbox|radio|range|button)$/.test(element.type))
  );
}

const CONTROLS = "button, a, [role=tab], [role=menuitem], [role=slider], [role=separator], summary";
const WITH_ARROWS =
  "[role=tree], [role=grid], [role=listbox], [role=tablist], [role=menu], [role=slider], [role=separator], input[type=range]";

/** Enter, Space and arrows belong to the control that has the focus. */
function belongsToControl(target: EventTarget | null, pressed: string): boolean {
  if (!(target instanceof Element)) return false;
  if (/^(Enter|Space)$/.test(pressed)) return target.closest(CONTROLS) !== null;
  return /^(Left|Right|Up|Down|Home|End|PgUp|PgDn)$/.test(pressed) && target.closest(WITH_ARROWS) !== null;
}

const isHeld = (event: KeyboardEvent): boolean => event.ctrlKey || event.metaKey || event.altKey;

/** The command of a sequence; else the newest of a key. Both can run now. */
function commandOf(all: Command[], pressed: string, sequence: string): Command | undefined {
  const able = all.filter((one) => one.when?.() ?? true);
  return (
    (sequence ? able.find((one) => one.keys.includes(sequence)) : undefined) ??
    able.findLast((one) => one.keys.includes(pressed))
  );
}

let before = "";
let beforeTimer = 0;

/** Listen, for as long as the application lives. */
export function followKeys(): void {
  addEventListener("keydown", (event) => {
    if (event.isComposing || event.defaultPrevented) return;
    const pressed = chord(event);
    const typing = isTyping(event.composedPath()[0] ?? event.target);
    const modified = isHeld(event) || pressed === "Esc";
    if (typing && !modified) return;
    if (!modified && !singleKeys.value) return;
    if (belongsToControl(event.target, pressed)) return;
    const sequence = before ? `${before} then ${pressed}` : "";
    const all = commands();
    const found = commandOf(all, pressed, sequence);
    const starts = !sequence && all.some((one) => one.keys.some((keys) => keys.startsWith(`${pressed} then `)));
    before = "";
    window.clearTimeout(beforeTimer);
    if (found) {
      event.preventDefault();
      found.run();
    } else if (starts) {
      before = pressed;
      beforeTimer = window.setTimeout(() => (before = ""), 1200);
    }
  });
}
