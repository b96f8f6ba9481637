/** What a person sets: for this browser, for their account; and what those who keep projects look after. */
import type { Signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { get } from "../../api/client";
import { subject } from "../../state/session/shell";
import { lazy } from "../../ui/lazy";
import { route } from "../../state/session/route";
import { LANGUAGES, language, languages, singleKeys, swapSides, theme, timeAs } from "../../state/session/settings";
import { useAsync } from "../../ui/useAsync";
import { w, type Word } from "../../words";
import { Account } from "./Account";
import "../../styles/settings.css";

const ProjectPage = lazy(async () => (await import("./ProjectPage")).ProjectPage);
const Activity = lazy(async () => (await import("./Activity")).Activity);
const Webhooks = lazy(async () => (await import("./Webhooks")).Webhooks);

const PAGES: { id: string; word: Word; right?: string }[] = [
  { id: "", word: "label.general" },
  { id: "projects", word: "label.projects" },
  { id: "activity", word: "label.activity" },
  { id: "webhooks", word: "label.webhooks", right: "own" },
];

export function Segments<T extends string | boolean>({
  value,
  options,
  label,
}: {
  value: Signal<T>;
  options: [T, string][];
  label: string;
}) {
  return (
    <div class="segments" role="group" aria-label={label}>
      {options.map(([one, text]) => (
        <button key={String(one)} type="button" aria-pressed={value.value === one} onClick={() => (value.value = one)}>
          {text}
        </button>
      ))}
    </div>
  );
}

export function SettingsPage() {
  useEffect(() => {
    subject.value = null;
  }, []);
  const me = useAsync((signal) => get("/account", { signal }), []);
  const open = PAGES.find((one) => one.id === route.value.id)?.id ?? "";
  return (
    <div class="page-pad">
      <h1>{w("label.settings")}</h1>
      <nav class="tabs settings-pages" aria-label={w("label.settings")}>
        {PAGES.filter((one) => !one.right || one.id === open || me.value?.rights.includes(one.right)).map((one) => (
          <a
            key={one.id}
            href={`/settings${one.id && "/"}${one.id}`}
            aria-current={one.id === open ? "page" : undefined}
          >
            {w(one.word)}
          </a>
        ))}
      </nav>
      {PAGES.map(
        (one) =>
          one.id !== "" &&
          one.id === open && (
            <h2 key={one.id} class="unseen">
              {w(one.word)}
            </h2>
          ),
      )}
      {open === "" && (
        <>
          <Browser />
          <Account />
        </>
      )}
      {open === "projects" && <ProjectPage />}
      {open === "activity" && <Activity />}
      {open === "webhooks" && <Webhooks />}
    </div>
  );
}

/** For this browser alone. */
function Browser() {
  return (
    <div class="form">
      <span>{w("label.theme")}</span>
      <Segments
        label={w("label.theme")}
        value={theme}
        options={[
          ["dark", w("label.dark")],
          ["light", w("label.light")],
          ["system", w("label.system")],
        ]}
      />
      <span>{w("label.language")}</span>
      <Segments
        label={w("label.language")}
        value={language}
        options={languages.map((known) => [known, LANGUAGES[known].name])}
      />
      <span>{w("label.sides")}</span>
      <Segments
        label={w("label.sides")}
        value={swapSides}
        options={[
          [false, w("label.sidesUsual")],
          [true, w("label.sidesSwapped")],
        ]}
      />
      <span>{w("label.timeAs")}</span>
      <Segments
        label={w("label.timeAs")}
        value={timeAs}
        options={[
          ["frame", w("label.frameNumbers")],
          ["seconds", w("label.seconds")],
          ["timecode", w("label.timecode")],
        ]}
      />
      <label for="single">{w("label.singleKeys")}</label>
      <span class="row">
        <input
          id="single"
          type="checkbox"
          checked={singleKeys.value}
          onChange={(event) => (singleKeys.value = event.currentTarget.checked)}
        />
        <span class="dim">{w("help.singleKeysHelp")}</span>
      </span>
    </div>
  );
}
