/** Cards of all clips under a filter, facets beside them, a preview of the one that is looked at. */
import { useEffect } from "preact/hooks";
import { get } from "../../api/client";
import { subject } from "../../state/session/shell";
import { lazy } from "../../ui/lazy";
import { offer } from "../../state/session/keys";
import { mayEdit } from "../../state/session/me";
import { ALL_PARTS } from "../../state/library/demo";
import * as library from "../../state/library/library";
import { facetsWide, leftFolded, previewOpen, previewWide } from "../../state/session/panes";
import { go, param, setParams } from "../../state/session/route";
import { Icon } from "../../ui/icons";
import { Splitter } from "../../ui/Splitter";
import { DemoProgress, EmptyState } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { isDemoAlone, welcomed } from "../../state/session/welcome";
import { w } from "../../words";
import { chooseFiles } from "../../state/importing/uploads";
import { CardGrid } from "./CardGrid";
import { CardList } from "./CardList";
import { Facets } from "./Facets";
import { FilterSheet } from "./FilterSheet";
import { FolderGrid, FolderPath, foldersShown } from "./Folders";
import { PickedBar } from "./PickedBar";
import { Preview } from "./Preview";
import { SortMenu } from "./SortMenu";
import "../../styles/library.css";

const Welcome = lazy(async () => (await import("./Welcome")).Welcome);

export function LibraryPage() {
  const view = param("view") === "list" ? "list" : "grid";
  const total = library.total.value;
  useEffect(() => {
    subject.value = null;
    library.look(0, 23);
    return offer("library", [
      {
        id: "open",
        word: "button.openClip",
        keys: ["Enter"],
        run: () => library.current.value && go(`/clips/${library.current.value}`),
        when: () => library.current.value !== null,
      },
      { id: "preview", word: "label.preview", keys: ["Space"], run: () => (previewOpen.value = !previewOpen.value) },
      {
        id: "delete",
        word: "button.delete",
        keys: ["Del"],
        run: () => void library.removeDocuments([...library.picked.value]),
        when: () => library.picked.value.size > 0 && mayEdit(),
      },
      {
        id: "compose",
        word: "button.moveToComposer",
        keys: ["M"],
        run: () => go(`/compose?s=${[...library.picked.value].join(",")}`),
        when: () => library.picked.value.size > 0,
      },
      {
        id: "none",
        word: "button.pickNone",
        keys: ["Esc"],
        run: () => (library.picked.value = new Set()),
        when: () => library.picked.value.size > 0,
      },
    ]);
  }, []);
  const filtered = Object.keys(library.filter.value).length > 0;
  // Asked only where it may matter: until it was closed, and again when clips come.
  const asks = !welcomed.value && !filtered && total !== null && total > 0;
  const projects = useAsync(
    async (signal) => (asks ? (await get("/projects", { signal })).items : null),
    [asks],
    [asks && total],
  );
  const first = asks && projects.value && isDemoAlone(projects.value);
  return (
    <div class="library">
      {!leftFolded.value && (
        <>
          <aside class="facets" style={{ width: `${facetsWide.value}px` }} aria-label={w("label.filters")}>
            <Facets />
          </aside>
          <Splitter size={facetsWide} least={180} most={420} initial={240} label={w("label.filters")} from="start" />
        </>
      )}
      <section class="cards" aria-label={w("label.library")}>
        <h1 class="unseen">{w("label.library")}</h1>
        <div class="toolbar row">
          <div class="segments" role="group" aria-label={w("label.view")}>
            <button type="button" aria-pressed={view === "grid"} onClick={() => setParams({ view: null })}>
              {w("label.grid")}
            </button>
            <button type="button" aria-pressed={view === "list"} onClick={() => setParams({ view: "list" })}>
              {w("label.list")}
            </button>
          </div>
          <SortMenu />
          <FilterSheet />
          <span class="grow" />
          <span class="dim" role="status">
            {total === null ? "" : w("label.clips", { n: total })}
          </span>
          <button type="button" class="button primary" onClick={() => chooseFiles()}>
            <Icon name="upload" />
            {w("button.queue")}
          </button>
        </div>
        <DemoProgress hidden={total === 0} />
        {first && <Welcome clips={total} />}
        <PickedBar />
        <FolderPath />
        <Trouble error={library.trouble.value} retry={library.refresh} />
        {total === 0 && !library.trouble.value ? <NoClips isFiltered={filtered} /> : <Clips isList={view === "list"} />}
      </section>
      {previewOpen.value && (
        <>
          <Splitter size={previewWide} least={260} most={520} initial={320} label={w("label.preview")} />
          <aside class="preview" style={{ width: `${previewWide.value}px` }} aria-label={w("label.preview")}>
            <Preview />
          </aside>
        </>
      )}
    </div>
  );
}

/** The clips under the filters: as folders until one is open, as cards or as rows. */
function Clips({ isList }: { isList: boolean }) {
  const { grouping, isClosed } = foldersShown();
  if (grouping && isClosed) return <FolderGrid grouping={grouping} />;
  return isList ? <CardList /> : <CardGrid />;
}

function NoClips({ isFiltered }: { isFiltered: boolean }) {
  const newProject = Object.keys(library.filter.value).join() === "project" && param("project");
  if (newProject)
    return (
      <div class="empty">
        <h2>{w("label.emptyProject", { name: newProject })}</h2>
        <p>{w("help.emptyProjectHelp")}</p>
        <p>
          <button type="button" class="button primary" onClick={() => chooseFiles()}>
            {w("button.chooseFiles")}
          </button>
        </p>
      </div>
    );
  if (isFiltered)
    return (
      <div class="empty">
        <h2>{w("label.noneMatch")}</h2>
        <p>{w("help.noneMatchHelp")}</p>
        <p>
          <a class="button" href="/library">
            {w("button.clearFilters")}
          </a>
        </p>
      </div>
    );
  return (
    <EmptyState picture="library" title={w("label.emptyLibrary")} makes={w("help.emptyLibraryHelp")} parts={ALL_PARTS}>
      <p class="dim">{w("help.dropAnywhere")}</p>
    </EmptyState>
  );
}
