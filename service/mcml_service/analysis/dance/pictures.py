"""Pictures of beats, of the graph of bars, and of a new dance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mcml_service.analysis.interface import Part, Parts, Picture
from mcml_service.analysis.pictures import (
    ACCENT,
    LINE,
    MOST_BARS,
    QUIET,
    WARM,
    columns_of,
    draw_edges,
    empty,
    ink,
    on_circle,
    say_more,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_CLIPS = 6
"""Of one picture: a row each."""


def draw_beats(parts: Parts, figure: Figure) -> None:
    """A row a clip: speed, its mean, beats, candidates that were rejected, bars."""
    series = parts["speed"].data["series"]
    shown = series[:MOST_CLIPS]
    fields = figure.subplots(len(shown), 1, squeeze=False)[:, 0]
    bars, facts = columns_of(parts["bars"]), {row["document"]: row for row in columns_of(parts["clips"])}
    candidates = columns_of(parts["candidates"])
    for axes, panel in zip(fields, shown, strict=True):
        own = [bar for bar in bars if bar["document"] == panel["document"]]
        left = [row for row in candidates if row["document"] == panel["document"] and row["verdict"] != "beat"]
        bpm = facts[panel["document"]]["bpm"]
        axes.set_title(panel["name"] + (f", {bpm:.1f} beats a minute" if bpm else ", no tempo found"))
        values = np.asarray(panel["values"]) / (panel["mean"] or 1.0)
        seconds = np.arange(len(values)) * panel["step"] / panel["fps"]
        for number, bar in enumerate(own):
            start, end = (bar["b0"] - 1) / panel["fps"], (bar["b3"] - 1) / panel["fps"]
            axes.axvspan(start, end, color=ACCENT, alpha=0.14 if number % 2 else 0.22, linewidth=0)
            if len(own) <= MOST_BARS:
                words = axes.get_xaxis_transform()
                axes.text(start, 0.98, f" {bar['bar']}", va="top", transform=words, color=ACCENT, fontsize=7)
        axes.plot(seconds, values, color="#141A22", linewidth=0.8)
        axes.axhline(1.0, color=LINE, linewidth=0.8, zorder=0)
        beats = np.asarray(panel["beats"])
        axes.plot(beats, np.interp(beats, seconds, values), "o", color=ACCENT, markersize=3, label="beat")
        refused = np.array([row["seconds"] for row in left])
        axes.plot(refused, np.interp(refused, seconds, values), "x", color=WARM, markersize=3, label="rejected")
        axes.set_xlim(0, seconds[-1] if len(seconds) else 1)
        axes.set_ylim(bottom=0)
        axes.set_ylabel("speed [mean]")
    fields[0].legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2)
    fields[-1].set_xlabel("time [s]")
    if len(series) > len(shown):
        say_more(fields[-1], f"and {len(series) - len(shown)} more clips")


def draw_bar_graph(parts: Parts, figure: Figure) -> None:
    """The graph of bars, and the distances that its jumps have."""
    left, right = figure.subplots(1, 2, width_ratios=(1.6, 1))
    names = {row["document"]: row["name"] for row in columns_of(parts["clips"])}
    (_circle if len(parts["graph"].data["nodes"]) <= MOST_BARS else _matrix)(left, parts["graph"], names)
    _distances(right, parts["graph"])


def _circle(axes: Axes, part: Part, names: dict[str, str]) -> None:
    """Draw bars on a circle, clip by clip, filled if a dance can continue without end; one line for each jump, the
    darker the nearer.
    """
    nodes = part.data["nodes"]
    edges, limit = part.data["edges"], part.data["threshold"] or 1.0
    axes.set_title(f"{len(nodes)} bars, {part.data['kept']} joined; {part.data['edges_in_all']:,} ways on")
    place = {node["id"]: on_circle(number, len(nodes)) for number, node in enumerate(nodes)}
    jumps = [edge for edge in edges if not edge["natural"]]
    draw_edges(axes, [(place[e["from"]], place[e["to"]], 1 - e["distance"] / (limit * 1.2)) for e in jumps])
    draw_edges(axes, [(place[e["from"]], place[e["to"]], 1.0) for e in edges if e["natural"]], ACCENT)
    for number, (document, name) in enumerate(names.items()):
        own = [node for node in nodes if node["document"] == document]
        if not own:
            continue
        x, y = zip(*(place[node["id"]] for node in own), strict=True)
        faces = [ink(number) if node["kept"] else "white" for node in own]
        axes.scatter(x, y, s=46, c=faces, edgecolors=ink(number), zorder=3, label=name)
    if len(nodes) <= MOST_BARS:
        for node in nodes:
            across, along = place[node["id"]]
            axes.text(1.12 * across, 1.12 * along, str(node["id"]), ha="center", va="center", fontsize=7)
    axes.set_aspect("equal")
    axes.set_xlim(-1.25, 1.25)
    axes.set_ylim(-1.25, 1.25)
    axes.set_axis_off()
    axes.legend(loc="lower left", ncols=2, bbox_to_anchor=(0, -0.12))


def _matrix(axes: Axes, part: Part, names: dict[str, str]) -> None:
    """Which bar (a row) may be followed by which (a column): the darker the nearer; lines where a clip begins."""
    nodes, pairs = part.data["nodes"], np.asarray(part.arrays["pairs"])
    axes.set_title(f"{len(nodes)} bars, {part.data['kept']} joined; {part.data['edges_in_all']:,} ways on")
    values = np.full((len(nodes), len(nodes)), np.nan)
    values[pairs[:, 0], pairs[:, 1]] = np.asarray(part.arrays["distances"])
    drawn = axes.imshow(values, cmap="viridis", interpolation="nearest", vmin=0)
    owners = [node["document"] for node in nodes]
    starts = [place for place, owner in enumerate(owners) if place == 0 or owner != owners[place - 1]]
    for start in starts[1:]:
        axes.axhline(start - 0.5, color=QUIET, linewidth=0.4)
        axes.axvline(start - 0.5, color=QUIET, linewidth=0.4)
    axes.set_yticks(starts, [names.get(owners[start], "") for start in starts], va="top")
    axes.set_xticks(starts, [names.get(owners[start], "") for start in starts], rotation=40, ha="right")
    axes.set_xlabel("may be followed by")
    axes.figure.colorbar(drawn, ax=axes, label="distance [body size]", shrink=0.6)


def _distances(axes: Axes, part: Part) -> None:
    axes.set_title("Distances of jumps")
    distances = np.asarray(part.arrays["distances"])[~np.asarray(part.arrays["natural"], dtype=bool)]
    if not len(distances):
        empty(axes, "No bar can follow another.")
        return
    axes.hist(distances, bins=min(40, max(5, len(distances) // 8)), color=ACCENT, alpha=0.7)
    axes.axvline(part.data["threshold"], color=WARM, linestyle="--", linewidth=1, label="threshold")
    axes.set_xlabel("distance [body size]")
    axes.set_ylabel("jumps")
    axes.legend()


def draw_dance(parts: Parts, figure: Figure) -> None:
    """The new dance: its speed with its beats and those of the music, and which bar is danced when."""
    if "speed" not in parts:
        _path(figure.subplots(), parts)
        return
    upper, lower = figure.subplots(2, 1, height_ratios=(1.4, 1))
    _speed(upper, parts["speed"])
    _path(lower, parts)


def _speed(axes: Axes, part: Part) -> None:
    axes.set_title("Speed and beats of the dance, on the beats of the music")
    speed, fps = np.asarray(part.arrays["speed"], dtype=float), part.data["series"][0]["fps"]
    values, seconds = speed / (speed.mean() or 1.0), np.arange(len(speed)) / fps
    beats = np.asarray(part.arrays["beats"])
    for place, beat in enumerate(np.asarray(part.arrays["grid"])):
        axes.axvline(beat, color=QUIET if place % 4 == 0 else LINE, linewidth=0.7, zorder=0)
    axes.plot(seconds, values, color="#141A22", linewidth=0.7)
    axes.plot(beats, np.interp(beats, seconds, values), "o", color=ACCENT, markersize=3)
    axes.set_xlim(0, seconds[-1] if len(seconds) else 1)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("time [s]; a line a beat of the music, the first of a bar darker")
    axes.set_ylabel("speed [mean]")


def _path(axes: Axes, parts: Parts) -> None:
    rows = columns_of(parts["path"])
    documents = list(dict.fromkeys(row["document"] for row in rows))
    axes.set_title(f"{len(rows)} bars of {len(documents)} clips")
    for number, row in enumerate(rows):
        axes.barh(0, 1, left=number, color=ink(documents.index(row["document"])), edgecolor="white", linewidth=1)
        if len(rows) <= MOST_BARS:
            axes.text(number + 0.5, 0, str(row["bar"]), ha="center", va="center", color="white", fontsize=7)
        if row["natural"] is False:
            axes.plot(number, 0.55, "v", color=WARM, markersize=4)
    axes.set_yticks([])
    axes.set_ylim(-0.6, 0.8)
    axes.set_xlim(0, max(1, len(rows)))
    axes.set_xlabel("bar of the dance (triangle: a jump)")


BEATS_PICTURES = {
    "beats": Picture(
        "Speed of each clip with beats, rejected candidates and bars",
        ("speed", "bars", "clips", "candidates"),
        draw_beats,
        (9.0, 6.5),
    )
}
GRAPH_PICTURES = {
    "graph": Picture("The graph of bars and the distances of its jumps", ("graph", "clips"), draw_bar_graph, (9.0, 5.0))
}
DANCE_PICTURES = {
    "dance": Picture(
        "Speed with beats of the new dance, and its path", ("path", "speed", "metrics"), draw_dance, (9.0, 5.0)
    ),
    **GRAPH_PICTURES,
}
