/** The frame around every page: rail, bar, toasts, palette, what is dropped, keys that work everywhere. */
import { useEffect } from "preact/hooks";
import { load, PAGES, rowOf, type PageRow } from "../pages";
import { followPrefetch } from "../state/session/prefetch";
import { formats } from "../state/session/formats";
import { go, page, route } from "../state/session/route";
import { copyText } from "../state/session/notes";
import { drawerOpen, keysOpen, paletteOpen } from "../state/session/shell";
import { offer, type Command } from "../state/session/keys";
import { leftFolded, rightFolded } from "../state/session/panes";
import { railWide } from "../state/session/settings";
import { Icon } from "../ui/icons";
import { w } from "../words";
import { Bar } from "./Bar";
import { DropTarget } from "./DropTarget";
import { focusHeading } from "./focusHeading";
import { Keys } from "./Keys";
import { lazy } from "../ui/lazy";
import { Palette } from "./Palette";
import { Tour } from "./Tour";
import { Toasts } from "./Toasts";
import { Connection } from "./Connection";
import { UploadTray } from "../panels/library/importing/UploadTray";

followPrefetch(async (name) => {
  const row = rowOf(name);
  if (row) await load(row);
});

/** Commands that open the pages of the rail. */
const toPages = (): Command[] =>
  PAGES.flatMap(({ name, path, go: word, key }) =>
    word && key ? [{ id: `go-${name}`, word, keys: [`G then ${key}`], run: () => go(path) }] : [],
  );

const VIEWS = new Map(PAGES.map((row) => [row.name, lazy(() => load(row))]));

export function App() {
  useEffect(() => void formats(), []);
  useEffect(
    () =>
      offer("shell", [
        { id: "help", word: "label.help", keys: ["?"], run: () => (keysOpen.value = !keysOpen.value) },
        { id: "palette", word: "label.palette", keys: ["Ctrl+K"], run: () => (paletteOpen.value = "") },
        {
          id: "search",
          word: "label.search",
          keys: ["/"],
          run: () => document.querySelector<HTMLElement>("[data-search]")?.focus(),
        },
        {
          id: "copy",
          word: "button.copyAddress",
          keys: ["Y"],
          run: () => void copyText(location.href, w("label.addressCopied")),
        },
        { id: "left", word: "button.leftPanel", keys: ["["], run: () => (leftFolded.value = !leftFolded.value) },
        { id: "right", word: "button.rightPanel", keys: ["]"], run: () => (rightFolded.value = !rightFolded.value) },
        ...toPages(),
        { id: "goY", word: "button.goActivity", keys: ["G then Y"], run: () => go("/settings/activity") },
      ]),
    [],
  );
  return (
    <div class="shell">
      <a class="skip" href="#page">
        {w("label.skip")}
      </a>
      <Bar />
      <Rail />
      <main id="page" tabIndex={-1}>
        <Connection />
        <PageOf />
      </main>
      <Tour />
      <UploadTray />
      <Toasts />
      <DropTarget />
      {paletteOpen.value !== null && <Palette />}
      {keysOpen.value && <Keys onClose={() => (keysOpen.value = false)} />}
    </div>
  );
}

function PageOf() {
  const { id } = route.value;
  const name = page.value;
  useEffect(() => {
    const main = document.getElementById("page");
    return main ? focusHeading(main) : undefined;
  }, [name, id]);
  const View = VIEWS.get(name);
  // Another thing is another page; another section is the same one.
  if (View) return <View id={id} key={rowOf(page.value)?.about === "section" ? page.value : `${page.value}/${id}`} />;
  return (
    <div class="empty">
      <h1>{w("error.unknownPage")}</h1>
      <p>
        <a href="/library">{w("button.toLibrary")}</a>
      </p>
    </div>
  );
}

function RailItem({ row }: { row: PageRow }) {
  const open = rowOf(page.value);
  const isOpen = open && (open.within ?? open.name) === row.name;
  return (
    <a
      class="rail-item"
      href={row.path}
      title={w(row.title)}
      aria-current={isOpen ? "page" : undefined}
      onClick={() => (drawerOpen.value = false)}
    >
      {row.icon && <Icon name={row.icon} />}
      <span>{w(row.title)}</span>
    </a>
  );
}

const railItems = (place: PageRow["rail"]) =>
  PAGES.filter((row) => row.rail === place).map((row) => <RailItem key={row.name} row={row} />);

function Rail() {
  return (
    <nav class={`rail ${railWide.value ? "wide" : ""} ${drawerOpen.value ? "open" : ""}`} aria-label={w("label.menu")}>
      {railItems("top")}
      <span class="grow" />
      <a class="rail-item" href="/docs/guide" title={w("label.guide")}>
        <Icon name="help" />
        <span>{w("label.guide")}</span>
      </a>
      <a class="rail-item" href="/docs" title={w("label.apiReference")}>
        <Icon name="code" />
        <span>{w("label.apiReference")}</span>
      </a>
      {railItems("end")}
      <button
        type="button"
        class="rail-item"
        title={w(railWide.value ? "button.unpin" : "button.pin")}
        aria-label={w(railWide.value ? "button.unpin" : "button.pin")}
        onClick={() => (railWide.value = !railWide.value)}
      >
        <Icon name={railWide.value ? "back" : "right"} />
        <span>{w("button.unpin")}</span>
      </button>
    </nav>
  );
}
