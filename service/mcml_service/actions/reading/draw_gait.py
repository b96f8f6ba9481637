"""A gait report as pages to print: parameters by side, curves over the cycle, warnings."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from mcml.errors import UnsupportedError
from mcml.laboratory.gait_events import SIDES, Side
from mcml.laboratory.gait_parameters import PARAMETERS, Summary, symmetry
from mcml.laboratory.gait_trials import Group
from mcml.laboratory.report_curves import ReportCurve
from mcml_service.actions.reading.compare_gait import Comparison
from mcml_service.analysis.pictures import LINE, QUIET, STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_A4: Final = (8.27, 11.69)
_INKS: Final[dict[Side, str]] = {"left": "#B3202C", "right": "#1F7A3D"}
"""Red and green, as clinics print the left and the right side."""
_COLUMNS: Final = 3
_ON_FIRST, _ON_OTHERS = 12, 15
"""Curves of a page."""
_BEHIND_TEXT: Final = {"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.6}
_MOST_WARNINGS: Final = 14
_WIDEST: Final = 130
"""Characters of a line of warnings."""


def draw_gait(comparison: Comparison) -> bytes:
    """Draw a report as PDF. Equal comparisons give equal bytes. Raises UnsupportedError without matplotlib."""
    try:
        import matplotlib
        from matplotlib.backends.backend_pdf import PdfPages
        from matplotlib.figure import Figure
    except ImportError:
        raise UnsupportedError(
            "Reports need matplotlib.", remedy="Install the extra `plots`: pip install 'mcml-repository[plots]'."
        ) from None
    curves = [curve for curve in comparison.curves if _has_cycles(comparison, curve)]
    starts = range(_ON_FIRST, len(curves), _ON_OTHERS)
    pages = [curves[:_ON_FIRST], *(curves[start : start + _ON_OTHERS] for start in starts)]
    content = io.BytesIO()
    with matplotlib.rc_context({**STYLE, "pdf.fonttype": 42}), PdfPages(content, metadata=_facts(comparison)) as pdf:
        for number, some in enumerate(pages):
            figure = Figure(figsize=_A4)
            top = _draw_head(figure, comparison) if number == 0 else 0.96
            bottom = 0.19 if number == len(pages) - 1 else 0.05
            _draw_curves(figure, comparison, some, top, bottom)
            if number == len(pages) - 1:
                _draw_warnings(figure, comparison)
            figure.text(0.06, 0.02, _explain(comparison), fontsize=6.5, color=QUIET)
            figure.text(0.94, 0.02, f"{number + 1} / {len(pages)}", ha="right", fontsize=7, color=QUIET)
            pdf.savefig(figure)
    return content.getvalue()


def _facts(comparison: Comparison) -> dict[str, Any]:
    title = f"Gait of {comparison.own.trials[0].name}"
    return {"Title": title, "Creator": "MCML Repository", "Producer": None, "CreationDate": None}


def _has_cycles(comparison: Comparison, curve: ReportCurve) -> bool:
    own = comparison.own
    return any(own.mean(quantity, side).n for side, quantity in curve.quantities.items())


def _draw_head(figure: Figure, comparison: Comparison) -> float:
    """Draw the title and the table of parameters; return how far down they reach."""
    figure.text(0.06, 0.955, "Gait report", fontsize=16, fontweight="bold")
    lines = [_line_of(name, group) for name, group in comparison.groups.items()]
    for row, line in enumerate(lines):
        figure.text(0.06, 0.935 - 0.014 * row, line, fontsize=8, color="#3F4B5A")
    headings = ["", "unit", "left", "right", "symmetry"]
    headings += ["left, other", "right, other"] if comparison.compare else []
    headings += ["left, normal", "right, normal"] if comparison.reference else []
    rows = [_row_of(comparison, parameter.name, parameter.unit) for parameter in PARAMETERS]
    top = 0.925 - 0.014 * len(lines)
    height = 0.0155 * (len(rows) + 1)
    from matplotlib.transforms import Bbox

    axes = figure.add_axes((0.06, top - height, 0.88, height))
    axes.set_axis_off()
    widths = [0.15, 0.09, *[0.76 / (len(headings) - 2)] * (len(headings) - 2)]
    table = axes.table(cellText=rows, colLabels=headings, colWidths=widths, cellLoc="right", bbox=Bbox.unit())
    table.auto_set_font_size(False)
    table.set_fontsize(7)
    for (row, column), cell in table.get_celld().items():
        cell.set_edgecolor(LINE)
        cell.visible_edges = "B"
        cell.get_text().set_color(_ink_of(headings[column]) if row else QUIET)
        if column == 0:
            cell.get_text().set_horizontalalignment("left")
    return top - height - 0.035


def _line_of(name: str, group: Group) -> str:
    titles = {"own": "Trials", "compare": "Compared with", "reference": "Normal band"}
    names = ", ".join(trial.name for trial in group.trials[:4])
    more = f" and {len(group.trials) - 4} more" if len(group.trials) > 4 else ""
    sources = sorted({event.source for trial in group.trials if trial.gait for event in trial.gait.events})
    kept = [stride.side for stride in group.strides if not stride.rejected]
    counts = f"{kept.count('left')} left and {kept.count('right')} right strides"
    told = f"; events from {', '.join(sources)}" if sources else ""
    return f"{titles[name]}: {names}{more} ({counts}{told})"


def _row_of(comparison: Comparison, name: str, unit: str) -> list[str]:
    left, right = (comparison.own.summary(side, name) for side in SIDES)
    index = symmetry(left.mean, right.mean)
    row = [
        name.replace("_", " "),
        unit,
        _text_of(left),
        _text_of(right),
        f"{index:.1f} %" if np.isfinite(index) else "–",
    ]
    for group in (comparison.compare, comparison.reference):
        if group is not None:
            row += [_text_of(group.summary(side, name)) for side in SIDES]
    return row


def _text_of(summary: Summary) -> str:
    if not np.isfinite(summary.mean):
        return "–"
    return f"{summary.mean:.3g}" + (f" ± {summary.sd:.2g}" if np.isfinite(summary.sd) else "")


def _ink_of(heading: str) -> str:
    return next((ink for side, ink in _INKS.items() if heading.startswith(side)), "#141A22")


def _draw_curves(
    figure: Figure, comparison: Comparison, curves: Sequence[ReportCurve], top: float, bottom: float
) -> None:
    rows = max(4, -(-len(curves) // _COLUMNS))
    grid = figure.add_gridspec(rows, _COLUMNS, left=0.09, right=0.94, top=top, bottom=bottom, hspace=0.62, wspace=0.38)
    for place, curve in enumerate(curves):
        _draw_curve(figure.add_subplot(grid[place // _COLUMNS, place % _COLUMNS]), comparison, curve)


def _draw_curve(axes: Axes, comparison: Comparison, curve: ReportCurve) -> None:
    percent = np.arange(101)
    if comparison.reference is not None:
        means = [comparison.reference.mean(quantity, side) for side, quantity in curve.quantities.items()]
        known = [mean for mean in means if mean.n > 1]
        if known:
            middle, wide = (np.mean([getattr(mean, part) for mean in known], axis=0) for part in ("mean", "sd"))
            axes.fill_between(percent, middle - wide, middle + wide, color="#C9D0D8", linewidth=0)
    for side, quantity in curve.quantities.items():
        mean = comparison.own.mean(quantity, side)
        if mean.n > 1:
            axes.fill_between(
                percent, mean.mean - mean.sd, mean.mean + mean.sd, color=_INKS[side], alpha=0.18, linewidth=0
            )
        if mean.n:
            axes.plot(percent, mean.mean, color=_INKS[side])
        if comparison.compare is not None and (other := comparison.compare.mean(quantity, side)).n:
            axes.plot(percent, other.mean, color=_INKS[side], linestyle=(0, (4, 2)), linewidth=0.9)
        off = comparison.own.summary(side, "stance").mean
        if np.isfinite(off):
            axes.axvline(off, color=_INKS[side], linewidth=0.7, linestyle=(0, (2, 2)))
    units = {comparison.own.units.get(quantity, "") for quantity in curve.quantities.values()}
    axes.set_title(f"{curve.title} [{', '.join(sorted(units))}]" if units - {""} else curve.title, fontsize=8)
    axes.set_xlim(0, 100)
    axes.set_xticks([0, 50, 100])
    axes.axhline(0, color=LINE, linewidth=0.6, zorder=0)
    axes.tick_params(labelsize=7)
    for text, place, align in ((curve.positive, 0.98, "top"), (curve.negative, 0.02, "bottom")):
        at = (0.015, place)
        axes.annotate(text, at, xycoords="axes fraction", fontsize=6, color=QUIET, va=align, bbox=_BEHIND_TEXT)


def _draw_warnings(figure: Figure, comparison: Comparison) -> None:
    lines = list(_warnings_of(comparison))
    shown = lines[:_MOST_WARNINGS]
    if len(lines) > len(shown):
        shown[-1] = f"and {len(lines) - len(shown) + 1} more warnings"
    for row, line in enumerate(shown):
        figure.text(0.06, 0.163 - 0.0095 * row, line, fontsize=6, color=QUIET)


def _explain(comparison: Comparison) -> str:
    keys = ["Left red, right green: mean ± standard deviation over strides", "dashed vertical: foot off"]
    keys += ["dashed curves: other trials"] if comparison.compare else []
    keys += ["grey: normal band"] if comparison.reference else []
    return "; ".join(keys)


def _warnings_of(comparison: Comparison) -> Iterable[str]:
    """Each warning once, with the trials that have it."""
    trials = list(chain.from_iterable(group.trials for group in comparison.groups.values()))
    by_warning: dict[str, list[str]] = {}
    for trial in trials:
        for warning in trial.warnings:
            by_warning.setdefault(warning, []).append(trial.name)
    for warning, names in by_warning.items():
        where = "" if len(trials) == 1 else f" ({', '.join(names[:3])}{' …' if len(names) > 3 else ''})"
        text = warning + where
        yield text if len(text) <= _WIDEST else text[: _WIDEST - 1] + "…"
