/** The graph as a table: the same bars and edges, for keys and for those who do not see it. */
import { itemAt } from "../../lists";
import { number } from "../../words";
import type { Edge, Graph, Node } from "./graph";
import { d } from "./words";

const MOST = 200;

export function GraphList({
  graph,
  names,
  onPick,
  onPlay,
}: {
  graph: Graph;
  names: (document: string) => string;
  onPick: (node: Node) => void;
  onPlay: (from: Node, to: Node) => void;
}) {
  const follow = new Map<number, Edge[]>();
  for (const edge of graph.edges) follow.set(edge.from, [...(follow.get(edge.from) ?? []), edge]);
  return (
    <div class="scrolls bench-list" role="region" tabIndex={0} aria-label={d("label.graph")}>
      <table>
        <thead>
          <tr>
            <th class="n">{d("label.bar")}</th>
            <th>{d("label.ofClip")}</th>
            <th>{d("label.follow")}</th>
          </tr>
        </thead>
        <tbody>
          {graph.nodes.slice(0, MOST).map((node, at) => (
            <tr key={node.bar}>
              <td class="n">
                <button
                  type="button"
                  class="link"
                  aria-label={d("label.barWord", { n: node.bar })}
                  onClick={() => onPick(node)}
                >
                  {node.bar}
                </button>
              </td>
              <td>
                {names(node.document)}, {node.number}
              </td>
              <td>
                {(follow.get(at) ?? [])
                  .sort((a, b) => Number(b.natural) - Number(a.natural) || a.distance - b.distance)
                  .slice(0, 8)
                  .map((edge) => (
                    <button
                      key={edge.to}
                      type="button"
                      class={`chip ${edge.natural ? "natural" : ""}`}
                      aria-label={`${d("button.play")}: ${d("label.edgeOf", { from: node.bar, to: itemAt(graph.nodes, edge.to).bar })}`}
                      onClick={() => onPlay(node, itemAt(graph.nodes, edge.to))}
                    >
                      {itemAt(graph.nodes, edge.to).bar} ·{" "}
                      {edge.natural ? d("label.naturalWord") : number(edge.distance, 3)}
                    </button>
                  ))}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
