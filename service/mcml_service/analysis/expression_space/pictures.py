"""Pictures of a space of expressions: the map with candidates, links and a path; how the threshold was chosen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mcml_service.analysis.interface import Part, Parts, Picture
from mcml_service.analysis.pictures import ACCENT, QUIET, WARM, columns_of, draw_edges, ink, say_more, thin

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_CANDIDATES = 120
"""Of the level that is drawn: the finest that a page can show."""
MOST_TAKES = 8
"""Limit of takes with separate colours."""


def draw_map(parts: Parts, figure: Figure) -> None:
    """Frames by take, candidates of a level with their links, and the path where the result is one."""
    axes = figure.subplots()
    places = parts["map"].arrays["coordinates"][:, :2]
    _frames(axes, parts["map"], places)
    level = _level(parts["levels"])
    first = parts["levels"].arrays["first"]
    candidates = np.asarray(parts["levels"].arrays["candidates"][first[level] : first[level + 1]])
    at = places[candidates]
    links = parts["links"].arrays
    span = slice(int(links["first"][level]), int(links["first"][level + 1]))
    pairs = zip(links["a"][span].tolist(), links["b"][span].tolist(), strict=True)
    draw_edges(axes, [(tuple(at[a]), tuple(at[b]), 0.45) for a, b in pairs])
    axes.scatter(at[:, 0], at[:, 1], s=26, facecolors="white", edgecolors="#141A22", linewidths=0.9, zorder=3)
    axes.set_title(_title(parts, level, len(candidates)))
    if "path" in parts:
        _path(axes, parts["path"], places)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("first axis of the map [mm]")
    axes.set_ylabel("second axis of the map [mm]")
    if len(parts["map"].data["names"]) <= MOST_TAKES:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), markerscale=3)
    else:
        say_more(axes, f"{len(parts['map'].data['names'])} takes, in {MOST_TAKES} colours")


def _frames(axes: Axes, part: Part, places: NDArray[np.float64]) -> None:
    takes, chosen = np.asarray(part.arrays["take"]), thin(len(places))
    for number, name in enumerate(part.data["names"]):
        own = places[chosen][takes[chosen] == number]
        label = name if number < MOST_TAKES else None
        axes.scatter(own[:, 0], own[:, 1], s=5, color=ink(number), alpha=0.5, linewidths=0, label=label, zorder=2)


def _level(part: Part) -> int:
    """The finest level that a page can show."""
    fitting = [row["level"] for row in columns_of(part) if row["candidates"] <= MOST_CANDIDATES]
    return max(fitting, default=0)


def _title(parts: Parts, level: int, count: int) -> str:
    about = parts["space"].data["summary"]
    words = f"{about['frames']:,} faces of {about['takes']} takes; level {level}: {count} candidates"
    fit = [f"{name} {about[name]:.2f}" for name in ("r", "stress") if about[name] is not None]
    return f"{words}; {', '.join(fit)}" if fit else words


def _path(axes: Axes, part: Part, places: NDArray[np.float64]) -> None:
    walk, at = np.asarray(part.arrays["walk"]), np.asarray(part.arrays["at"])
    way, keys = places[walk], places[walk[at]]
    axes.plot(way[:, 0], way[:, 1], color=ACCENT, linewidth=2, zorder=4)
    axes.scatter(keys[:, 0], keys[:, 1], s=36, color=ACCENT, edgecolors="white", linewidths=1, zorder=5)
    for number, (x, y) in enumerate(keys):
        axes.annotate(str(number + 1), (x, y), xytext=(5, 4), textcoords="offset points", weight="bold", zorder=6)


def draw_threshold(parts: Parts, figure: Figure) -> None:
    """Thresholds that were tried: how well the map agrees, and into how many parts the graph falls."""
    axes = figure.subplots()
    arrays, about = parts["tau"].arrays, parts["tau"].data
    tau = np.asarray(arrays["tau"])
    order = np.argsort(tau)
    axes.set_title("Choosing the threshold")
    axes.plot(tau[order], np.asarray(arrays["r"])[order], color=ACCENT, marker=".", label="correlation r")
    axes.plot(tau[order], np.asarray(arrays["stress"])[order], color=QUIET, marker=".", label="stress")
    axes.axvline(about["chosen"], color=WARM, linestyle="--", linewidth=1, label="chosen")
    axes.set_ylim(0, 1.05)
    axes.set_xlabel("threshold [mm]")
    parted = np.asarray(arrays["components"])[order]
    if (parted > 1).any():
        beside = axes.twinx()
        beside.step(tau[order], parted, where="mid", color=WARM, alpha=0.5)
        beside.set_yscale("log")
        beside.set_ylabel("parts of the graph", color=WARM)
    axes.legend(loc="center right")


PICTURES = {
    "map": Picture(
        "The map with candidates, links, and the path where there is one",
        ("map", "space", "levels", "links", "path"),
        draw_map,
        (9.0, 6.5),
    ),
    "threshold": Picture("Thresholds that were tried", ("tau",), draw_threshold),
}
