/** Clips to take pieces from, by words; or runs of frames, by XPath. Dragged, or added by a press. */
import { useState } from "preact/hooks";
import { get, type Schemas } from "../../api/client";
import { Icon } from "../../ui/icons";
import { ThumbnailView } from "../../ui/clips/ThumbnailView";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { useClips } from "../../ui/clips/useClips";
import { useThumbnail } from "../../ui/clips/useThumbnail";
import { number, w } from "../../words";
import { carry, type Board, type Taken } from "./board";

const WAIT = 400; // ms after the last letter of a question
const MOST_RUNS = 100;

export function Bin({ board }: { board: Board }) {
  const [text, setText] = useState("");
  const asks = /^\s*[/(]/.test(text);
  return (
    <>
      <input
        class={`field ${asks ? "code" : ""}`}
        type="search"
        data-search
        aria-label={w("label.search")}
        placeholder={w("label.binSearch")}
        value={text}
        onInput={(event) => setText(event.currentTarget.value)}
      />
      {asks ? <Runs board={board} query={text.trim()} /> : <Clips board={board} text={text} />}
    </>
  );
}

function Clips({ board, text }: { board: Board; text: string }) {
  const [hovered, setHovered] = useState("");
  const clips = useClips(text);
  return (
    <>
      <Trouble error={clips.error} retry={clips.again} />
      {clips.value?.length === 0 && <p class="dim">{w("label.noneMatch")}</p>}
      <ul class="bin-list">
        {(clips.value ?? []).map((one) => (
          <Row
            key={one.id}
            board={board}
            taken={{ id: one.id, name: one.name }}
            detail={one.time}
            onHover={(on) => setHovered(on ? one.id : "")}
          >
            <ThumbnailView thumbnail={one.thumb} runs={hovered === one.id} label="" />
          </Row>
        ))}
      </ul>
    </>
  );
}

function Runs({ board, query }: { board: Board; query: string }) {
  const runs = useAsync(
    async (signal) => {
      await new Promise((resolve) => setTimeout(resolve, WAIT));
      signal.throwIfAborted();
      const answer = (await get("/xpath", {
        query: { q: query, as: "runs", limit: MOST_RUNS, with: "totals" },
        signal,
      })) as Schemas["QueryAnswer"];
      return { items: (answer.items ?? []) as Schemas["RunItem"][], total: answer.totals?.runs ?? 0 };
    },
    [query],
  );
  const found = runs.error ? undefined : runs.value;
  return (
    <>
      {runs.busy && <div class="busy" />}
      <Trouble error={runs.error} />
      {found && (
        <div class="row wrap">
          <span class="dim grow" role="status">
            {w("label.runCount", { n: found.total })}
          </span>
          {found.items.length > 0 && (
            <button type="button" class="button dense" onClick={() => board.add(found.items.map(takenOf))}>
              <Icon name="plus" />
              {w("button.addAll", { n: found.items.length })}
            </button>
          )}
          {found.total > found.items.length && <span class="dim">{w("help.binFirst", { n: found.items.length })}</span>}
        </div>
      )}
      <ul class="bin-list">
        {(found?.items ?? []).map((one) => (
          <Row
            key={`${one.document} ${one.first}`}
            board={board}
            taken={takenOf(one)}
            detail={`${number(one.first)}–${number(one.last)}`}
          >
            <RunPicture run={one} />
          </Row>
        ))}
      </ul>
    </>
  );
}

const takenOf = (run: Schemas["RunItem"]): Taken => ({
  id: run.document,
  name: run.name,
  first: run.first,
  last: run.last,
});

function RunPicture({ run }: { run: Schemas["RunItem"] }) {
  const thumbnail = useThumbnail(run.document);
  const [over, setOver] = useState(false);
  return (
    <span class="block" onPointerEnter={() => setOver(true)} onPointerLeave={() => setOver(false)}>
      <ThumbnailView thumbnail={thumbnail} runs={over} label="" />
    </span>
  );
}

function Row({
  board,
  taken,
  detail,
  onHover,
  children,
}: {
  board: Board;
  taken: Taken;
  detail: string;
  onHover?: (on: boolean) => void;
  children: preact.ComponentChildren;
}) {
  const range = taken.first ? ` ${detail}` : "";
  return (
    <li
      draggable
      onPointerEnter={() => onHover?.(true)}
      onPointerLeave={() => onHover?.(false)}
      onDragStart={(event) => carry(event, [taken])}
    >
      {children}
      <span class="grow">
        <span class="cut block" title={taken.name}>
          {taken.name}
        </span>
        <span class="dim">{detail}</span>
      </span>
      <button
        type="button"
        class="button quiet icon dense"
        title={w("button.add")}
        aria-label={`${w("button.add")} ${taken.name}${range}`}
        onClick={() => board.add([taken])}
      >
        <Icon name="plus" />
      </button>
      {board.pieces.value.length > 0 && (
        <button
          type="button"
          class="button quiet icon dense"
          title={w("button.addLayer")}
          aria-label={`${w("button.addLayer")} ${taken.name}${range}`}
          onClick={() => board.addLayer(taken)}
        >
          <Icon name="layer" />
        </button>
      )}
    </li>
  );
}
