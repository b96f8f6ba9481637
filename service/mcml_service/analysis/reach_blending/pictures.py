"""Pictures of a fit: variance held by components, phases on the speed of the arm, attributes, errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mcml_service.analysis.interface import Parts, Picture
from mcml_service.analysis.pictures import ACCENT, INKS, LINE, QUIET, WARM, columns_of, empty, say_more

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PHASES = (("prepare", INKS[4]), ("reach", ACCENT), ("settle", WARM))
_PREDICTORS = {"model": "this model", "linear": "straight line", "nearest": "nearest example"}
MOST_CURVES = 200


def draw_fit(parts: Parts, figure: Figure) -> None:
    """Draw four panels: variance, phases, attributes, errors of left-out clips."""
    fields = figure.subplots(2, 2)
    _variance(fields[0, 0], parts)
    _phases(fields[0, 1], parts)
    _attributes(fields[1, 0], parts)
    _errors(fields[1, 1], parts)


def _variance(axes: Axes, parts: Parts) -> None:
    axes.set_title("Variance that components hold")
    for name, words, ink in (("variance", "eigenmotions", ACCENT), ("pose_variance", "eigenposes", WARM)):
        if name in parts:
            arrays = parts[name].arrays
            axes.plot(arrays["components"], 100 * np.asarray(arrays["cumulative"]), marker=".", color=ink, label=words)
    summary: dict[str, Any] = parts["model"].data["summary"]
    if summary["components"]:
        axes.axvline(summary["components"], color=QUIET, linestyle=":", linewidth=1)
        axes.annotate(f"{summary['components']} kept", (summary["components"], 2), color=QUIET, fontsize=7)
    axes.set_ylim(0, 102)
    axes.set_xlabel("components")
    axes.set_ylabel("variance [%]")
    axes.legend(loc="lower right")


def _phases(axes: Axes, parts: Parts) -> None:
    """Speeds of the phase joint over time, each clip's phases brought to the mean ones."""
    summary = parts["model"].data["summary"]
    axes.set_title(f"Phases on the angular speed, {summary['phase_joint']}")
    speed, first = np.asarray(parts["speed"].arrays["speed"]), np.asarray(parts["speed"].arrays["first"])
    mean = [summary["mean_times"][name]["seconds"] for name in ("t1", "t2", "end")]
    knots = [0.0, *mean]
    rows = {row["document"]: row for row in columns_of(parts["clips"])}
    drawn = 0
    for place, document in enumerate(parts["speed"].data["documents"]):
        row = rows[document]
        if not row["used"] or drawn >= MOST_CURVES:
            continue
        drawn += 1
        own = speed[first[place] : first[place + 1]]
        seconds = np.arange(len(own)) / row["fps"]
        inside = seconds <= row["end_seconds"]
        times = [0.0, row["t1_seconds"], row["t2_seconds"], row["end_seconds"]]
        axes.plot(np.interp(seconds[inside], times, knots), own[inside], color=QUIET, alpha=0.25, linewidth=0.6)
    for (words, ink), start, end in zip(_PHASES, knots, mean, strict=False):
        axes.axvspan(start, end, color=ink, alpha=0.10, linewidth=0)
        axes.text(
            (start + end) / 2, 0.98, words, ha="center", va="top", transform=axes.get_xaxis_transform(), color=ink
        )
    axes.set_xlim(0, mean[-1])
    axes.set_ylim(bottom=0)
    axes.set_xlabel("time, phases brought to their means [s]")
    axes.set_ylabel("speed [rad/s]")


def _attributes(axes: Axes, parts: Parts) -> None:
    """Examples along each attribute, gaps hatched."""
    axes.set_title("Examples")
    values = np.asarray(parts["attributes"].arrays["attributes"])
    about = parts["model"].data["summary"]["attributes"]
    spread = np.random.default_rng(0)
    for row, attribute in enumerate(about):
        width = (attribute["greatest"] - attribute["least"]) or 1.0
        where = (values[:, row] - attribute["least"]) / width
        axes.hlines(row, 0, 1, color=LINE, linewidth=1)
        axes.scatter(where, row + spread.uniform(0.05, 0.3, len(where)), s=5, color=ACCENT, alpha=0.6, linewidths=0)
        for low, high in attribute["gaps"]:
            a, b = (low - attribute["least"]) / width, (high - attribute["least"]) / width
            axes.fill_between(
                [a, b], row - 0.08, row + 0.35, facecolor="none", edgecolor=WARM, hatch="////", linewidth=0
            )
        unit = f" {attribute['unit']}" if attribute["unit"] else ""
        for at, value, side in ((0, attribute["least"], "left"), (1, attribute["greatest"], "right")):
            axes.annotate(f"{value:g}{unit}", (at, row - 0.12), ha=side, va="top", fontsize=7, color=QUIET)
    axes.set_yticks(range(len(about)), [attribute["name"] for attribute in about])
    axes.set_ylim(-0.5, len(about) - 0.4)
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)
    if any(attribute["gaps"] for attribute in about):
        say_more(axes, "hatched: no examples")


def _errors(axes: Axes, parts: Parts) -> None:
    """Draw the mean error of joints for clips left out of the fit, with the two simple predictors."""
    axes.set_title("Error for clips left out")
    rows = [row for row in columns_of(parts["errors"]) if row["joint"] is not None and row["left_out"] != "nothing"]
    groups = list(dict.fromkeys(row["left_out"] for row in rows))
    if not rows:
        empty(axes, "Too few clips to leave any out.")
        return
    predictors = list(dict.fromkeys(row["predictor"] for row in rows))
    height = 0.8 / len(predictors)
    for place, predictor in enumerate(predictors):
        own = {row["left_out"]: row["joint"] for row in rows if row["predictor"] == predictor}
        at = [number + 0.4 - height * (place + 0.5) for number, group in enumerate(groups) if group in own]
        ink = ACCENT if place == 0 else (QUIET, LINE)[min(1, place - 1)]
        words = _PREDICTORS.get(predictor, predictor)
        bars = axes.barh(at, [own[group] for group in groups if group in own], height * 0.9, color=ink, label=words)
        axes.bar_label(bars, fmt="%.2f", fontsize=6, padding=2)
    axes.set_yticks(range(len(groups)), [f"one {group}" for group in groups])
    axes.set_xlabel("joint angles [degree]")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3)


PICTURES = {
    "fit": Picture(
        "Variance of components, phases, examples and errors",
        ("model", "variance", "pose_variance", "speed", "clips", "attributes", "errors"),
        draw_fit,
        (9.0, 6.5),
    )
}
