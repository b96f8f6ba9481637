/** The bar: where one is, one box to find anything, jobs, language, theme. */
import { LANGUAGES, language, languages, theme } from "../state/session/settings";
import { page } from "../state/session/route";
import { Icon } from "../ui/icons";
import { Menu } from "../ui/Menu";
import { SearchBox } from "../panels/library/SearchBox";
import { rowOf } from "../pages";
import { w } from "../words";
import { JobTray } from "./JobTray";
import { drawerOpen, keysOpen, paletteOpen, subject } from "../state/session/shell";

export function Bar() {
  const word = rowOf(page.value)?.title;
  const about = subject.value;
  document.title = [about?.text, word && w(word), w("label.product")].filter(Boolean).join(" · ");
  return (
    <header class="bar">
      <button
        type="button"
        class="button quiet icon drawer-button"
        aria-label={w("label.menu")}
        aria-expanded={drawerOpen.value}
        onClick={() => (drawerOpen.value = !drawerOpen.value)}
      >
        <Icon name="list" />
      </button>
      <a class="mark" href="/library" aria-label={w("label.library")}>
        <img src="/favicon.svg" alt="" width="24" height="24" />
      </a>
      <div class="where cut">
        {page.value === "clip" ? (
          <>
            <a href="/library" class="cut">
              {w("label.library")}
            </a>
            <span class="dim"> › </span>
            <strong class="cut">{about?.text ?? "…"}</strong>
          </>
        ) : (
          <strong>{word ? w(word) : ""}</strong>
        )}
        {about?.detail && <span class="chip">{about.detail}</span>}
      </div>
      {page.value === "library" ? (
        <SearchBox />
      ) : (
        <button type="button" class="finder" title={w("label.searchAll")} onClick={() => (paletteOpen.value = "")}>
          <Icon name="search" />
          <span class="grow cut">{w("label.searchAll")}</span>
          <kbd>Ctrl K</kbd>
        </button>
      )}
      <div class="bar-end">
        <JobTray />
        <Menu
          label={w("label.language")}
          className="chip"
          side="right"
          items={languages.map((known) => ({
            text: LANGUAGES[known].name,
            checked: language.value === known,
            run: () => (language.value = known),
          }))}
        >
          {LANGUAGES[language.value].mark}
        </Menu>
        <Menu
          label={w("label.theme")}
          className="chip"
          side="right"
          items={(["dark", "light", "system"] as const).map((one) => ({
            text: w(`label.${one}`),
            checked: theme.value === one,
            run: () => (theme.value = one),
          }))}
        >
          <Icon name="eye" />
        </Menu>
        <button
          type="button"
          class="chip"
          aria-label={w("label.help")}
          title={`${w("label.help")} (?)`}
          onClick={() => (keysOpen.value = true)}
        >
          ?
        </button>
      </div>
    </header>
  );
}
