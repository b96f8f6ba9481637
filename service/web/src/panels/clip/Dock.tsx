/** The views of the document beside the viewer. One of them is open; the address says which. */
import type { Clip } from "../../state/clip/clip";
import { param, setParams } from "../../state/session/route";
import { Tabs } from "../../ui/Tabs";
import type { Word } from "../../words";
import { w } from "../../words";
import { Body } from "./body/Body";
import { Comments } from "./document/Comments";
import { Graph } from "./timeline/Graph";
import { History } from "./document/History";
import { Proposals } from "./review/Proposals";
import { r, v } from "./words";
import { Info } from "./document/Info";
import { Structure } from "./body/Structure";
import { Tree } from "./document/Tree";
import { lazy } from "../../ui/lazy";

const Text = lazy(async () => (await import("./document/Text")).TextView);

const Gait = lazy(async () => (await import("./gait/Gait")).Gait);

const MediaTab = lazy(async () => (await import("./media/MediaTab")).MediaTab);

const VIEWS: { id: string; word: Word | (() => string) }[] = [
  { id: "tree", word: "label.tree" },
  { id: "graph", word: "label.graph" },
  { id: "body", word: "label.bodyTab" },
  { id: "gait", word: "label.gait" },
  { id: "structure", word: "label.structure" },
  { id: "text", word: "label.text" },
  { id: "history", word: "label.history" },
  { id: "proposals", word: () => r("label.proposals") },
  { id: "comments", word: "label.comments" },
  { id: "video", word: () => v("label.video") },
  { id: "info", word: "label.info" },
];

export function Dock({ clip, reload }: { clip: Clip; reload: () => void }) {
  const open = VIEWS.some((one) => one.id === param("tab")) ? param("tab") : "tree";
  return (
    <>
      <Tabs
        label={w("label.dock")}
        tabs={VIEWS.map((one) => ({ id: one.id, text: typeof one.word === "string" ? w(one.word) : one.word() }))}
        open={open}
        onOpen={(id) => setParams({ tab: id === "tree" ? null : id })}
      />
      <div class="dock-view" role="tabpanel" id={`panel-${open}`} aria-labelledby={`tab-${open}`}>
        {open === "tree" && <Tree clip={clip} />}
        {open === "graph" && <Graph clip={clip} reload={reload} />}
        {open === "body" && <Body clip={clip} reload={reload} />}
        {open === "gait" && <Gait clip={clip} reload={reload} />}
        {open === "structure" && <Structure clip={clip} reload={reload} />}
        {open === "text" && <Text clip={clip} reload={reload} />}
        {open === "history" && <History clip={clip} reload={reload} />}
        {open === "comments" && <Comments clip={clip} />}
        {open === "proposals" && <Proposals key={clip.detail.revision} clip={clip} reload={reload} />}
        {open === "video" && <MediaTab clip={clip} reload={reload} />}
        {open === "info" && <Info clip={clip} reload={reload} />}
      </div>
    </>
  );
}
