"""The figures of a new dance, beside those of the classic blend and of its sources."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcml_service.analysis.dance.assembly import Dance
from mcml_service.analysis.dance.choreography import Plan
from mcml_service.analysis.dance.floor import measure_way
from mcml_service.analysis.dance.metrics import (
    Watched,
    clip_extremes,
    greatest,
    grid_metrics,
    inside,
    mean_or_none,
    of_transition,
    watch,
)
from mcml_service.analysis.dance.sources import Clip, Search
from mcml_service.analysis.dance.stage import Stage
from mcml_service.analysis.dance.tables import table
from mcml_service.analysis.interface import Part

_FIGURES = ("speed_variance", "speed_peak", "beats_inside", "foot_skate")


@dataclass(frozen=True)
class Measured:
    """watched: the new dance. metrics, transitions: tables."""

    watched: Watched
    metrics: Part
    transitions: Part


def measure(
    clips: Sequence[Clip],
    dance: Dance,
    classic: Dance | None,
    plan: Plan,
    fps: float,
    search: Search,
    stage: Stage | None = None,
) -> Measured:
    """Figures of a dance. classic: the same path with the classic blend; None where the dance is that."""
    figure = clips[0].figure
    options = (search.locate, search.k2, search.k3, search.smooth)
    watched = watch(figure, dance.translations, dance.rotations, fps, *options)
    beside = watched if classic is None else watch(figure, classic.translations, classic.rotations, fps, *options)
    jumped = [place for place, natural in enumerate(plan.natural) if not natural]
    rows = []
    own = [of_transition(watched, transition) for transition in dance.transitions]
    other = [of_transition(beside, transition) for transition in dance.transitions]
    for step, transition, mine, theirs in zip(jumped, dance.transitions, own, other, strict=True):
        pair = [plan.path[step] + 1, plan.path[step + 1] + 1]
        figures = [*(mine[name] for name in _FIGURES), *(theirs[name] for name in _FIGURES)]
        span = [transition.start, transition.end]
        rows.append([transition.position + 1, *pair, *span, float(plan.distances[step]), *figures])
    columns = [
        "position",
        "from",
        "to",
        "start",
        "end",
        "distance",
        *_FIGURES,
        *(f"classic_{name}" for name in _FIGURES),
    ]
    time = np.arange(len(watched.raw)) / fps
    within = inside(time, dance.transitions)
    sources = [clip_extremes(clip.figure, clip.motion.translations, clip.motion.rotations, clip.fps) for clip in clips]
    values: dict[str, float | int | None] = {
        "seconds": len(time) / fps,
        "frames": len(time),
        "bars": len(plan.path),
        "jumps": len(jumped),
        **_uses(plan),
        **_places(dance, clips[0], stage),
        "energy_match": plan.energy_match,
        **grid_metrics(watched, plan.grid),
        "beats_in_transitions": sum(int(found["beats_inside"] or 0) for found in own),
        "classic_beats_in_transitions": sum(int(found["beats_inside"] or 0) for found in other),
        "foot_skate_in_transitions": mean_or_none(watched.foot_speed[within]),
        "classic_foot_skate_in_transitions": mean_or_none(beside.foot_speed[within]),
        "foot_skate_outside": mean_or_none(watched.foot_speed[~within]),
        "greatest_rotation_speed": float(np.degrees(greatest(watched.turning))),
        "source_greatest_rotation_speed": float(np.degrees(max(turning for turning, _ in sources))),
        "greatest_body_speed": greatest(watched.moving),
        "source_greatest_body_speed": float(max(moving for _, moving in sources)),
        "greatest_rate": greatest(dance.rate),
        "least_rate": float(dance.rate.min(initial=0.0)),
    }
    metrics = table(["metric", "value"], list(values.items()))
    return Measured(watched, metrics, table(columns, rows))


def _uses(plan: Plan) -> dict[str, float | int | None]:
    """Different bars of the dance, those that it could have, the share of the ones in the others, most uses of one."""
    uses = np.bincount(plan.path)
    used, available = int((uses > 0).sum()), int(plan.kept.sum())
    return {
        "bars_used": used,
        "bars_available": available,
        "coverage": used / available,
        "most_uses": int(uses.max()),
    }


def _places(dance: Dance, first: Clip, stage: Stage | None) -> dict[str, float | int | None]:
    """The farthest place of the root from its first one, the middle of the stage, and how far it leaves the stage."""
    way = measure_way(dance.translations, first)
    outside = None if stage is None else greatest(stage.outside(way))
    return {"farthest_from_centre": greatest(np.abs(way)), "outside_stage": outside}
