/** The frame around every page: rail, bar, toasts, palette, what is dropped, keys that work everywhere. */
import { useEffect } from "preact/hooks";
import { LibraryPage } from "../panels/library/LibraryPage";
import { SettingsPage } from "../panels/settings/SettingsPage";
import { go, loadedBy, page, route } from "../state/route";
import { copyText } from "../state/notes";
import { drawerOpen, keysOpen, paletteOpen } from "../state/shell";
import { offer } from "../state/keys";
import { leftFolded, rightFolded } from "../state/panes";
import { railWide } from "../state/settings";
import { Icon, type IconName } from "../ui/icons";
import { w, type Word } from "../words";
import { Bar } from "./Bar";
import { DropTarget } from "./DropTarget";
import { Keys } from "./Keys";
import { lazy } from "../ui/lazy";
import { Palette } from "./Palette";
import { Toasts } from "./Toasts";
import { Connection } from "./Connection";
import { UploadTray } from "../panels/library/UploadTray";

const clipPage = async () => (await import("../panels/clip/ClipPage")).ClipPage;
const ClipPage = lazy(clipPage);
loadedBy("clip", clipPage);
const XPathPage = lazy(async () => (await import("../panels/xpath/XPathPage")).XPathPage);
const ComposerPage = lazy(async () => (await import("../panels/composer/ComposerPage")).ComposerPage);
const RetargetPage = lazy(async () => (await import("../panels/retarget/RetargetPage")).RetargetPage);
const BlenderPage = lazy(async () => (await import("../panels/blender/BlenderPage")).BlenderPage);
const DancePage = lazy(async () => (await import("../panels/dance/DancePage")).DancePage);
const FacesPage = lazy(async () => (await import("../panels/faces/FacesPage")).FacesPage);
const AnalysesPage = lazy(async () => (await import("../panels/analyses/AnalysesPage")).AnalysesPage);
const ResultPage = lazy(async () => (await import("../panels/analyses/ResultPage")).ResultPage);

const RAIL: { page: string; icon: IconName; word: Word; path: string }[] = [
  { page: "library", icon: "library", word: "library", path: "/library" },
  { page: "xpath", icon: "xpath", word: "xpath", path: "/xpath" },
  { page: "compose", icon: "compose", word: "compose", path: "/compose" },
  { page: "retarget", icon: "retarget", word: "retarget", path: "/retarget" },
  { page: "reach", icon: "blender", word: "blender", path: "/reach" },
  { page: "dance", icon: "beat", word: "dance", path: "/dance" },
  { page: "faces", icon: "face", word: "faces", path: "/faces" },
  { page: "analyses", icon: "chart", word: "analyses", path: "/analyses" },
];

export function App() {
  useEffect(
    () =>
      offer("shell", [
        { id: "help", word: "help", keys: ["?"], run: () => (keysOpen.value = !keysOpen.value) },
        { id: "palette", word: "palette", keys: ["Ctrl+K"], run: () => (paletteOpen.value = "") },
        {
          id: "search",
          word: "search",
          keys: ["/"],
          run: () => document.querySelector<HTMLElement>("[data-search]")?.focus(),
        },
        { id: "copy", word: "copyAddress", keys: ["Y"], run: () => void copyText(location.href, w("addressCopied")) },
        { id: "left", word: "leftPanel", keys: ["["], run: () => (leftFolded.value = !leftFolded.value) },
        { id: "right", word: "rightPanel", keys: ["]"], run: () => (rightFolded.value = !rightFolded.value) },
        { id: "goL", word: "goLibrary", keys: ["G then L"], run: () => go("/library") },
        { id: "goX", word: "goXpath", keys: ["G then X"], run: () => go("/xpath") },
        { id: "goC", word: "goCompose", keys: ["G then C"], run: () => go("/compose") },
        { id: "goR", word: "goRetarget", keys: ["G then R"], run: () => go("/retarget") },
        { id: "goB", word: "goBlender", keys: ["G then B"], run: () => go("/reach") },
        { id: "goD", word: "goDance", keys: ["G then D"], run: () => go("/dance") },
        { id: "goF", word: "goFaces", keys: ["G then F"], run: () => go("/faces") },
        { id: "goS", word: "goSettings", keys: ["G then S"], run: () => go("/settings") },
        { id: "goA", word: "goActivity", keys: ["G then A"], run: () => go("/settings/activity") },
      ]),
    [],
  );
  return (
    <div class="shell">
      <a class="skip" href="#page">
        {w("skip")}
      </a>
      <Bar />
      <Rail />
      <main id="page" tabIndex={-1}>
        <Connection />
        <PageOf />
      </main>
      <UploadTray />
      <Toasts />
      <DropTarget />
      {paletteOpen.value !== null && <Palette />}
      {keysOpen.value && <Keys onClose={() => (keysOpen.value = false)} />}
    </div>
  );
}

function PageOf() {
  const { id, params } = route.value;
  switch (page.value) {
    case "library":
      return <LibraryPage />;
    case "clip":
      return <ClipPage id={id} revision={params.get("rev")} key={`${id}@${params.get("rev") ?? ""}`} />;
    case "xpath":
      return <XPathPage />;
    case "compose":
      return <ComposerPage />;
    case "retarget":
      return <RetargetPage />;
    case "reach":
      return <BlenderPage id={id} key={id} />;
    case "dance":
      return <DancePage id={id} key={id} />;
    case "faces":
      return <FacesPage id={id} key={id} />;
    case "analyses":
      return <AnalysesPage id={id} key={id} />;
    case "results":
      return <ResultPage id={id} key={id} />;
    case "settings":
      return <SettingsPage />;
    default:
      return (
        <div class="empty">
          <h1>{w("unknownPage")}</h1>
          <p>
            <a href="/library">{w("toLibrary")}</a>
          </p>
        </div>
      );
  }
}

function Rail() {
  const entry = (one: (typeof RAIL)[number]) => (
    <a
      key={one.page}
      class="rail-item"
      href={one.path}
      title={w(one.word)}
      aria-current={
        page.value === one.page ||
        (one.page === "library" && page.value === "clip") ||
        (one.page === "analyses" && page.value === "results")
          ? "page"
          : undefined
      }
      onClick={() => (drawerOpen.value = false)}
    >
      <Icon name={one.icon} />
      <span>{w(one.word)}</span>
    </a>
  );
  return (
    <nav class={`rail ${railWide.value ? "wide" : ""} ${drawerOpen.value ? "open" : ""}`} aria-label={w("menu")}>
      {RAIL.map(entry)}
      <span class="grow" />
      <a class="rail-item" href="/docs" title={w("apiReference")}>
        <Icon name="help" />
        <span>{w("apiReference")}</span>
      </a>
      {entry({ page: "settings", icon: "settings", word: "settings", path: "/settings" })}
      <button
        type="button"
        class="rail-item"
        title={w(railWide.value ? "unpin" : "pin")}
        aria-label={w(railWide.value ? "unpin" : "pin")}
        onClick={() => (railWide.value = !railWide.value)}
      >
        <Icon name={railWide.value ? "back" : "right"} />
        <span>{w("unpin")}</span>
      </button>
    </nav>
  );
}
