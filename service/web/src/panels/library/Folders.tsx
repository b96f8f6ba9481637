/** The library as folders of one property: a grid of folders, the path of the open one, and the choice of the property. */
import { get, type Schemas } from "../../api/client";
import {
  folderAddress,
  foldersOf,
  groupingsOf,
  MOST_FOLDERS,
  openFolder,
  readGrouping,
  type Folder,
  type Grouping,
} from "../../state/library/folders";
import * as library from "../../state/library/library";
import { labelOf } from "../../state/session/formats";
import { param, route, setParams } from "../../state/session/route";
import { nameColour } from "../../motion/timeline/colours";
import { Icon } from "../../ui/icons";
import { MiddleCut } from "../../ui/MiddleCut";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { useRoving } from "../../ui/useRoving";
import { number, w, type Word } from "../../words";
import { i } from "./words";

const WORDS: Record<string, Word> = {
  project: "label.project",
  motion_name: "label.motionName",
  format: "label.format",
  skeleton: "label.skeleton",
  rate: "label.frameRate",
};

const textOfGrouping = (grouping: Grouping): string => {
  const word = WORDS[grouping];
  return word ? w(word) : grouping.slice("property:".length);
};

function textOf(grouping: Grouping, { value, joints }: Pick<Folder, "value" | "joints">): string {
  if (grouping === "format") return labelOf(value);
  if (grouping === "rate") return `${number(Number(value))} Hz`;
  if (grouping === "skeleton" && joints !== undefined) return `${value} · ${w("label.jointCount", { n: joints })}`;
  return value;
}

/** The grouping of the address, and whether its folders are shown: none of them is open. */
export function foldersShown(): { grouping: Grouping | null; isClosed: boolean } {
  const grouping = readGrouping(param("folders"));
  return { grouping, isClosed: grouping !== null && openFolder(library.filter.value, grouping) === null };
}

export function FolderChoice({ found }: { found: Schemas["FacetList"] }) {
  const { grouping } = foldersShown();
  const offered = groupingsOf(found);
  if (grouping && !offered.includes(grouping)) offered.push(grouping);
  if (!offered.length) return null;
  return (
    <label class="folder-choice">
      {i("label.foldersBy")}
      <select
        class="field"
        value={grouping ?? ""}
        onChange={(event) => setParams({ folders: event.currentTarget.value || null }, true)}
      >
        <option value="">{i("label.noFolders")}</option>
        {offered.map((one) => (
          <option key={one} value={one}>
            {textOfGrouping(one)}
          </option>
        ))}
      </select>
    </label>
  );
}

/** Where one is among the folders, with the way back. */
export function FolderPath() {
  const { grouping, isClosed } = foldersShown();
  if (!grouping) return null;
  const value = openFolder(library.filter.value, grouping);
  return (
    <nav class="folder-path row" aria-label={i("label.folders")}>
      {isClosed || value === null ? (
        <strong>{textOfGrouping(grouping)}</strong>
      ) : (
        <>
          <a href={folderAddress(library.filter.value, route.value.params, grouping, null)}>
            {textOfGrouping(grouping)}
          </a>
          <span class="dim">›</span>
          <strong class="cut">{textOf(grouping, { value })}</strong>
        </>
      )}
      <button
        type="button"
        class="button quiet icon dense"
        aria-label={i("button.closeFolders")}
        title={i("button.closeFolders")}
        onClick={() => setParams({ folders: null }, true)}
      >
        <Icon name="close" />
      </button>
    </nav>
  );
}

export function FolderGrid({ grouping }: { grouping: Grouping }) {
  const facets = useAsync(
    (signal) => get("/facets", { query: { ...library.filter.value, limit: MOST_FOLDERS, bins: 1 }, signal }),
    [JSON.stringify(library.filter.value)],
    [library.total.value],
  );
  const roving = useRoving<HTMLUListElement>("a");
  const found = facets.value ?? facets.before;
  if (!found) return <Trouble error={facets.error} retry={facets.again} />;
  const folders = foldersOf(found, grouping);
  return (
    <div class="folders">
      {folders.length === 0 && <p class="dim">{i("help.noFolders")}</p>}
      {folders.length === MOST_FOLDERS && <p class="dim">{i("help.mostFolders", { n: MOST_FOLDERS })}</p>}
      <ul aria-label={i("label.folders")} {...roving}>
        {folders.map((one) => (
          <li key={one.value}>
            <a class="folder" href={folderAddress(library.filter.value, route.value.params, grouping, one.value)}>
              {grouping === "motion_name" ? (
                <span class="swatch" style={{ background: nameColour(one.value) }} />
              ) : (
                <Icon name="folder" />
              )}
              <strong>
                <MiddleCut text={textOf(grouping, one)} />
              </strong>
              <span class="dim">{w("label.clips", { n: one.documents })}</span>
            </a>
          </li>
        ))}
      </ul>
    </div>
  );
}
