"""Draw results with matplotlib: shared colours and styles, and drawing a part by its kind.

The caller (`actions.analysing.draw_result`) provides figures and axes; nothing here opens a window.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mcml_service.analysis.interface import Part, Parts, Picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ACCENT, WARM, QUIET, LINE = "#0A7568", "#B8400F", "#738091", "#D3DAE3"
INKS = ("#004555", "#C25600", "#26806A", "#A65E93", "#6068E8", "#4D3A00", "#78249D", "#8A4441")
"""Colours of named items, such as clips: distinguishable with any colour vision, on white."""

STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.size": 8,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": "#3F4B5A",
    "text.color": "#141A22",
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelcolor": "#3F4B5A",
    "ytick.labelcolor": "#3F4B5A",
    "legend.frameon": False,
    "legend.fontsize": 7,
    "lines.linewidth": 1.2,
    # Text stays text, so that a journal's fonts and a reader's search find it.
    "svg.fonttype": "none",
    # The same result gives the same bytes.
    "svg.hashsalt": "mcml",
}

MOST_POINTS = 20_000
"""Of a curve or a cloud; more are thinned evenly."""
MOST_ROWS = 24
MOST_BARS = 40


def ink(number: int) -> str:
    """The colour of the nth named thing."""
    return INKS[number % len(INKS)]


def columns_of(part: Part) -> list[dict[str, Any]]:
    """The rows of a table, each by the names of its columns."""
    names = [column["name"] for column in part.data["columns"]]
    return [dict(zip(names, row, strict=True)) for row in part.data["rows"]]


def axis_words(about: Mapping[str, Any] | None) -> str:
    """`{"name": "tau", "unit": "mm"}` as the words at an axis."""
    if not about:
        return ""
    return f"{about['name']} [{about['unit']}]" if about.get("unit") else str(about["name"])


def say_more(axes: Axes, what: str) -> None:
    """Add text below a picture about omitted data."""
    axes.annotate(
        what, (1, 0), (0, -28), "axes fraction", "offset points", ha="right", va="top", fontsize=7, color=QUIET
    )


def empty(axes: Axes, what: str) -> None:
    """Draw text instead of a picture."""
    axes.set_axis_off()
    axes.text(0.5, 0.5, what, ha="center", va="center", color=QUIET, transform=axes.transAxes)


def thin(count: int) -> slice:
    """Return a slice that thins `count` values, so that at most MOST_POINTS are drawn."""
    return slice(None, None, max(1, -(-count // MOST_POINTS)))


def picture_of_part(name: str, part: Part, description: str = "") -> Picture:
    """Return a picture of one part by its kind, for analyses without their own pictures."""

    def draw(parts: Parts, figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_title(name)
        {"curve": draw_curve, "points": draw_points, "graph": draw_graph}.get(part.kind, draw_table)(axes, parts[name])

    return Picture(description or name, (name,), draw)


def draw_curve(axes: Axes, part: Part) -> None:
    """A curve: the arrays that its axes name; or its `series`, each with `values`."""
    x, y = part.data.get("x"), part.data.get("y")
    axes.set_xlabel(axis_words(x))
    axes.set_ylabel(axis_words(y))
    series: Sequence[Mapping[str, Any]] = part.data.get("series") or ()
    for number, line in enumerate(series[: len(INKS)]):
        axes.plot(line["values"], color=ink(number), label=str(line.get("name", number + 1)))
    if series:
        axes.legend()
    elif y and y["name"] in part.arrays:
        values = np.asarray(part.arrays[y["name"]], dtype=float)
        step = thin(len(values))
        along = np.asarray(part.arrays[x["name"]] if x and x["name"] in part.arrays else np.arange(len(values)))
        axes.plot(along[step], values[step], color=ACCENT)
    else:
        empty(axes, "This curve names no values.")


def draw_points(axes: Axes, part: Part) -> None:
    """Points: the first array that has two columns or more."""
    points = next((array for array in part.arrays.values() if array.ndim == 2 and array.shape[1] >= 2), None)
    if points is None:
        empty(axes, "These points have no coordinates.")
        return
    values = np.asarray(points)[thin(len(points))]
    axes.scatter(values[:, 0], values[:, 1], s=4, color=ACCENT, linewidths=0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(axis_words({"name": "first axis", "unit": part.data.get("unit", "")}))
    axes.set_ylabel(axis_words({"name": "second axis", "unit": part.data.get("unit", "")}))


def draw_graph(axes: Axes, part: Part) -> None:
    """A graph: nodes on a circle, edges of `data.edges` as lines, the nearer the darker."""
    nodes, edges = part.data.get("nodes") or (), part.data.get("edges") or ()
    if not nodes:
        empty(axes, "This graph lists no nodes.")
        return
    place = {node["id"]: on_circle(number, len(nodes)) for number, node in enumerate(nodes)}
    draw_edges(axes, [(place[edge["from"]], place[edge["to"]], 1.0) for edge in edges[:MOST_POINTS]])
    x, y = zip(*place.values(), strict=True)
    axes.scatter(x, y, s=30, color=ACCENT, zorder=3)
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw_table(axes: Axes, part: Part) -> None:
    """The first rows of a table as text; the plain values of any other part."""
    axes.set_axis_off()
    heads = [axis_words(column) for column in part.data.get("columns", ())]
    rows = part.data.get("rows") or [[name, value] for name, value in part.data.items() if not isinstance(value, dict)]
    heads = heads or ["name", "value"]
    cells = [[_cell(value) for value in row[: len(heads)]] for row in rows[:MOST_ROWS]]
    if not cells:
        empty(axes, "This table is empty.")
        return
    drawn = axes.table(cells, colLabels=heads, loc="upper left", cellLoc="left", edges="horizontal")
    drawn.auto_set_font_size(False)
    drawn.set_fontsize(7)
    drawn.auto_set_column_width(range(len(heads)))
    if len(rows) > MOST_ROWS:
        axes.text(1, 0, f"and {len(rows) - MOST_ROWS:,} more rows", ha="right", fontsize=7, color=QUIET)


def on_circle(number: int, count: int) -> tuple[float, float]:
    """Return the place of the nth node on a circle, clockwise from the top."""
    angle = np.pi / 2 - 2 * np.pi * number / max(1, count)
    return float(np.cos(angle)), float(np.sin(angle))


def draw_edges(
    axes: Axes, edges: Sequence[tuple[tuple[float, float], tuple[float, float], float]], color: str = QUIET
) -> None:
    """Lines (from, to, strength 0 to 1), the stronger the darker."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import to_rgba

    inks = [to_rgba(color, 0.08 + 0.72 * min(1.0, max(0.0, strength))) for *_, strength in edges]
    axes.add_collection(LineCollection([edge[:2] for edge in edges], colors=inks, linewidths=0.7, zorder=1))


def _cell(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no"}.get(value, "")  # type: ignore[arg-type]  # None is neither
    if isinstance(value, float):
        return f"{value:.4g}"
    text = str(value)
    return text if len(text) <= 40 else f"{text[:39]}…"
