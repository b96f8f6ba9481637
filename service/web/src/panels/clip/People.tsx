/** Others at the clip: their initials, and a word where one of them edits it. */
import { others, type Present } from "../../state/clip/presence";
import { language } from "../../state/session/settings";
import { w } from "../../words";

const SHOWN = 4;

/** One or two letters by which people know each other. */
function initials(name: string): string {
  const words = name.split(/[\s._-]+/).filter(Boolean);
  const letters =
    words.length > 1 ? words.slice(0, 2).map((word) => [...word][0]) : [...(words[0] ?? name)].slice(0, 2);
  return letters.join("").toLocaleUpperCase();
}

function told(one: Present): string {
  const since = new Date(one.since).toLocaleTimeString(language.value, { hour: "numeric", minute: "2-digit" });
  return w(one.doing === "editing" ? "label.isEditing" : "label.isViewing", { who: one.name, since });
}

export function People() {
  const all = others.value;
  if (!all.length) return null;
  const more = all
    .slice(SHOWN)
    .map((one) => one.name)
    .join(", ");
  return (
    <ul class="people row" aria-label={w("label.peopleHere")}>
      {all.slice(0, SHOWN).map((one) => (
        <li key={one.name}>
          <span class={`avatar ${one.doing}`} role="img" aria-label={told(one)} title={told(one)}>
            {initials(one.name)}
          </span>
        </li>
      ))}
      {more && (
        <li>
          <span
            class="avatar"
            role="img"
            aria-label={w("label.moreHere", { who: more })}
            title={w("label.moreHere", { who: more })}
          >
            +{all.length - SHOWN}
          </span>
        </li>
      )}
    </ul>
  );
}

export function OthersEdit() {
  const who = others.value.filter((one) => one.doing === "editing").map((one) => one.name);
  if (!who.length) return null;
  return (
    <p class="others-edit row" role="status">
      <span class="dot" />
      {w("help.othersEdit", { who: who.join(", "), n: who.length })}
    </p>
  );
}
