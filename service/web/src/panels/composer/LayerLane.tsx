/** The layers on one piece: where each begins, how long it lasts. Edges trim, the middle moves, a drop adds one. */
import { useSignal } from "@preact/signals";
import { partNamed } from "../../motion/body/parts";
import { sizeOf, type Layer, type Piece } from "../../state/editing/composition";
import { number, w } from "../../words";
import { carried, type Board } from "./board";
import { facts } from "./facts";
import { PART_WORDS } from "./partWords";
import { edgeAt, follow, trimmed } from "./trimming";

/** What a layer moves, in words. */
export function bonesInWords(board: Board, layer: Layer): string {
  const body = facts.value.get(board.pieces.value[0]?.document ?? "")?.skeleton.view.bones;
  const part = body && partNamed(body, layer.bones);
  return part ? w(PART_WORDS[part]) : w("label.jointCount", { n: layer.bones.length });
}

export function LayerLane({ board, piece, index }: { board: Board; piece: Piece; index: number }) {
  const over = useSignal(false);
  const own = useSignal<ReturnType<typeof placeOf> | null>(null);
  const size = Math.max(1, sizeOf(piece));
  const here = board.at.value;
  const rate = (document: string) => facts.value.get(document)?.perSecond ?? 30;
  const onDrop = (event: DragEvent) => {
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    over.value = false;
    const at = Math.max(1, Math.min(size, Math.round(((event.clientX - box.left) / box.width) * size)));
    for (const taken of carried(event)) board.addLayer(taken, index, at);
  };
  const take = (event: PointerEvent, layer: Layer, scale: number) => {
    if (event.button) return;
    event.stopPropagation();
    board.chosen.value = { kind: "layer", key: layer.key };
    const lane = (event.currentTarget as HTMLElement).parentElement!.getBoundingClientRect();
    const edge = edgeAt(event, (event.currentTarget as HTMLElement).getBoundingClientRect());
    const perPixel = size / lane.width; // frames of the piece
    const spans = facts.peek().get(layer.document)?.spans ?? [];
    const found = placeOf(layer);
    follow(
      event,
      (pixels, move) => {
        if (edge && layer.frames) {
          const cut = trimmed(layer, edge, pixels, perPixel / scale, spans, move.altKey);
          // What is taken off the front moves the beginning along: the rest stays where it is.
          const at = edge === "first" ? Math.round(layer.at + (cut.first - layer.first) * scale) : layer.at;
          Object.assign(found, cut, { edge, at: Math.max(1, at) });
        } else
          Object.assign(found, {
            edge: "move",
            at: Math.max(1, Math.min(size, Math.round(layer.at + pixels * perPixel))),
          });
        own.value = { ...found };
      },
      (cancelled) => {
        own.value = null;
        if (!cancelled && found.edge) board.setLayer(layer.key, { first: found.first, last: found.last, at: found.at });
      },
    );
  };
  return (
    <div
      class={`layer-lane ${over.value ? "over" : ""}`}
      onDragOver={(event) => {
        event.preventDefault();
        event.stopPropagation();
        over.value = true;
      }}
      onDragLeave={() => (over.value = false)}
      onDrop={onDrop}
    >
      {piece.layers.map((each) => {
        const layer = own.value?.key === each.key ? { ...each, ...own.value } : each;
        const scale = rate(piece.document) / rate(layer.document); // frames of the piece for one of the layer
        const length = Math.min(size - layer.at + 1, Math.max(1, sizeOf(layer)) * scale);
        return (
          <div key={each.key} class="layer-row">
            <button
              type="button"
              class="layer"
              aria-pressed={here?.kind === "layer" && here.layer.key === each.key}
              aria-label={`${w("label.layer")}: ${layer.name}, ${bonesInWords(board, layer)}, ${w("label.frame")} ${number(layer.at)}`}
              style={{
                left: `${((layer.at - 1) / size) * 100}%`,
                width: `${(length / size) * 100}%`,
                opacity: 0.4 + 0.6 * layer.strength,
              }}
              onPointerDown={(event) => take(event, each, scale)}
              onClick={() => (board.chosen.value = { kind: "layer", key: each.key })}
              onKeyDown={(event) => {
                const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
                if (!step || event.altKey) return;
                board.setLayer(each.key, { at: each.at + step * (event.shiftKey ? 10 : 1) }, "at");
                event.preventDefault();
                event.stopPropagation();
              }}
            >
              <span class="cut">
                {layer.name || "…"} <span class="dim">{bonesInWords(board, layer)}</span>
              </span>
            </button>
          </div>
        );
      })}
    </div>
  );
}

/** A layer's place while it is dragged. */
function placeOf(layer: Layer) {
  return { key: layer.key, first: layer.first, last: layer.last, at: layer.at, edge: "" };
}
