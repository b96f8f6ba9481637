"""The figures of several dancers: their distances, and the bars and way of each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mcml_service.analysis.dance.group_dance.dancers import Dancer, find_ways
from mcml_service.analysis.dance.group_dance.formation import find_nearest
from mcml_service.analysis.dance.measured import Measured
from mcml_service.analysis.dance.metrics import grid_metrics, watch
from mcml_service.analysis.dance.sources import Clip, Search
from mcml_service.analysis.dance.stage import NEAR, Stage
from mcml_service.analysis.dance.tables import table
from mcml_service.analysis.interface import Part


def measure_group(
    clips: Sequence[Clip],
    dancers: Sequence[Dancer],
    measured: Measured,
    fps: float,
    search: Search,
    stage: Stage | None,
) -> tuple[dict[str, Part], list[str]]:
    """The parts `metrics`, `dancers` and `places` of several dancers, and warnings.

    measured: the figures of the first dancer; places and distances in the metrics are those of all.
    """
    ways = find_ways(dancers, clips[0])
    middle = 0.0 if stage is not None else complex(ways[:, 0].mean())
    outside = [None if stage is None else float(stage.outside(way).max()) for way in ways]
    least, frame, (one, other) = find_nearest(ways)
    rows: list[list[Any]] = []
    for number, dancer in enumerate(dancers):
        plan = dancer.plan
        aligned = grid_metrics(measured.watched, dancers[0].plan.grid)
        if plan.path != dancers[0].plan.path:
            options = (search.locate, search.k2, search.k3, search.smooth)
            watched = watch(clips[0].figure, dancer.dance.translations, dancer.dance.rotations, fps, *options)
            aligned = grid_metrics(watched, plan.grid)
        uses = np.bincount(plan.path)
        rows.append(
            [
                number + 1,
                float(plan.grid[0]),
                float(plan.grid[-1]),
                int((uses > 0).sum()),
                int(uses.max()),
                aligned["beat_align_music"],
                aligned["beat_align_motion"],
                float(np.abs(ways[number] - middle).max()),
                outside[number],
                [bar + 1 for bar in plan.path],
            ]
        )
    columns = ["dancer", "start", "end", "bars_used", "most_uses", "beat_align_music", "beat_align_motion"]
    columns += ["farthest_from_centre", "outside_stage", "path"]
    values = dict(measured.metrics.data["rows"]) | {
        "seconds": ways.shape[1] / fps,
        "frames": ways.shape[1],
        "most_uses": max(row[4] for row in rows),
        "farthest_from_centre": max(row[7] for row in rows),
        "outside_stage": None if stage is None else max(row[8] for row in rows),
        "dancers": len(dancers),
        "least_distance": least,
        "least_distance_at": frame / fps,
    }
    warnings = []
    if least < NEAR:
        warnings.append(
            f"Dancers {one + 1} and {other + 1} come within {least:.2f} m of each other at {frame / fps:.1f} s. Use a "
            "larger spacing or stage, more clips, or raise stage_turn."
        )
    parts = {
        "metrics": table(["metric", "value"], list(values.items())),
        "dancers": table(columns, rows),
        "places": _places(dancers, ways, fps),
    }
    return parts, warnings


def _places(dancers: Sequence[Dancer], ways: Any, fps: float) -> Part:
    """Places of the roots on every beat of the whole dance, metres: X to the left of the stage, Z to its front."""
    beats = np.unique(np.concatenate([dancer.plan.grid for dancer in dancers]).round(9))
    time = np.arange(ways.shape[1]) / fps
    rows = [
        [number + 1, float(beat), float(x), float(z)]
        for number, way in enumerate(ways)
        for beat, x, z in zip(beats, np.interp(beats, time, way.real), np.interp(beats, time, way.imag), strict=True)
    ]
    return table(["dancer", "seconds", "x", "z"], rows)
