"""Results as parts for people and programs. Frames count from 1 in tables, as in all answers; from 0 in arrays.

A table has data `columns` (name, unit) and `rows`; a curve has `x` and `y` (name, unit), `series` and arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.motion.skeleton import Array
from mcml_service.analysis.dance.bar_graph import FAR, AllBars, BarGraph
from mcml_service.analysis.dance.bars import find_held_frames
from mcml_service.analysis.dance.choreography import Plan
from mcml_service.analysis.dance.motion_beats import REASONS, half_up, whole
from mcml_service.analysis.dance.sources import Clip
from mcml_service.analysis.dance.stage import Stage
from mcml_service.analysis.interface import Part

SHOWN = 2000
"""Values of a curve in its data; all are in the arrays."""
LISTED = 20_000
"""Limit of rows in a table; omitted rows are counted."""
MOST_JUMPS = 200_000
"""Of a graph, that another threshold can be tried on."""
JUMP = 6.0
"""Mean speeds of a clip. Real dances reach 3; files that begin with a pose of calibration 12 to 65."""
_UNITS = {
    "fps": "1/s",
    "mean_speed": "unit/s",
    "period": "s",
    "bpm": "1/min",
    "seconds": "s",
    "beat_seconds": "s",
    "start": "s",
    "end": "s",
    "distance": "body size",
    "dip": "mean speed",
    "rest": "mean speed",
    "speed_peak": "mean speed",
    "farthest_from_centre": "m",
    "outside_stage": "m",
    "x": "m",
    "z": "m",
    "foot_skate": "body size/s",
}


def table(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> Part:
    """A table: columns with the units of their names, and rows of plain values."""
    heads = [{"name": name, "unit": _UNITS.get(name.removeprefix("classic_"), "")} for name in columns]
    data: dict[str, Any] = {"columns": heads, "rows": [list(row) for row in rows[:LISTED]]}
    if len(rows) > LISTED:
        data["left_out"] = len(rows) - LISTED
    return Part("table", data)


def clips_table(clips: Sequence[Clip]) -> Part:
    """One row a clip: rate, mean speed, candidates by verdict, beats, period and its rivals, bars, which beats and
    why."""
    columns = ["document", "name", "frames", "fps", "mean_speed", "candidates", *(f"refused_{r}" for r in REASONS[1:])]
    columns += ["beats", "period", "bpm", "peaks", "bars", "beats_from", "support"]
    columns += ["tempo_clear", "tempo_rival", "tempo_octave", "tempo_steady"]
    columns += ["beats_reason", "bars_detected", "bars_tracked", "jump"]
    rows = []
    for clip in clips:
        refused = [int((clip.candidates.verdicts == verdict).sum()) for verdict in range(1, len(REASONS))]
        peaks = [{"period": p.seconds, "bpm": 60 / p.seconds, "strength": p.strength} for p in clip.peaks]
        bpm = None if clip.period is None else 60 / clip.period
        row = [clip.motion.document, clip.motion.name, len(clip.motion), clip.fps, float(clip.speed.mean())]
        row += [len(clip.candidates.frames), *refused, len(clip.bars.beats), clip.period, bpm, peaks]
        row += [len(clip.bars.bars), clip.bars.source, clip.bars.support]
        tempo = clip.tempo
        row += [None] * 4 if tempo is None else [tempo.clear, tempo.rival, tempo.octave, tempo.steady]
        rows.append([*row, clip.bars.reason, *(clip.bars.compared or (None, None)), jump_of(clip)])
    return table(columns, rows)


def warnings_table(texts: Sequence[str], clips: Sequence[Clip]) -> Part:
    """Return warnings, including doubts about the tempi of clips; code: an identifier for programs, if there is one."""
    tempi = {
        (code, f"{'All clips' if len({id(c.tempo) for c in clips}) < len(clips) else clip.motion.name}: {sentence}")
        for clip in clips
        if clip.tempo is not None
        for code, sentence in clip.tempo.warnings()
    }
    return table(
        ["warning", "code"],
        [*([text, None] for text in texts), *([sentence, code] for code, sentence in sorted(tempi))],
    )


def jump_of(clip: Clip) -> int | None:
    """The frame, from 1, at which the body moves faster than any dancer would: a pose that belongs to another clip."""
    fastest = int(clip.speed.argmax())
    return fastest + 1 if clip.speed[fastest] > JUMP * clip.speed.mean() else None


def speed_curve(clips: Sequence[Clip]) -> Part:
    """Speed of each clip, thinned in the data, whole in the arrays, with its beats and candidates."""
    series = []
    arrays: dict[str, NDArray[Any]] = {}
    for clip in clips:
        document, step = clip.motion.document, max(1, -(-len(clip.speed) // SHOWN))
        series.append(
            {
                "document": document,
                "name": clip.motion.name,
                "fps": clip.fps,
                "step": step,
                "values": clip.speed[::step].tolist(),
                "mean": float(clip.speed.mean()),
                "beats": (clip.bars.beats / clip.fps).tolist(),
            }
        )
        arrays[f"speed-{document}"] = clip.speed
        arrays[f"beats-{document}"] = clip.bars.beats
        arrays[f"candidates-{document}"] = clip.candidates.frames
        arrays[f"verdicts-{document}"] = clip.candidates.verdicts
    axes = {"x": {"name": "time", "unit": "s"}, "y": {"name": "speed", "unit": "unit/s"}}
    return Part("curve", {**axes, "series": series}, arrays)


def candidates_table(clips: Sequence[Clip]) -> Part:
    """Every minimum with its verdict: beat, end, or the condition that it fails first."""
    rows = []
    for clip in clips:
        candidates = clip.candidates
        for frame, verdict, dip, rest in zip(
            candidates.frames, candidates.verdicts, candidates.dips, candidates.rests, strict=True
        ):
            time = float(frame / clip.fps)
            rows.append([clip.motion.document, int(frame) + 1, time, REASONS[verdict], float(dip), float(rest)])
    return table(["document", "frame", "seconds", "verdict", "dip", "rest"], rows)


def beats_table(clips: Sequence[Clip]) -> Part:
    """The beats that bars are made of."""
    rows = [
        [clip.motion.document, number + 1, half_up(frame) + 1, float(frame / clip.fps), bool(supported)]
        for clip in clips
        for number, (frame, supported) in enumerate(zip(clip.bars.beats, clip.bars.supported, strict=True))
    ]
    return table(["document", "beat", "frame", "seconds", "supported"], rows)


def bars_table(clips: Sequence[Clip]) -> Part:
    """Bars of each clip: beats, where the lead-in starts and the beat after ends, held frames, tempo."""
    rows = []
    for clip in clips:
        bars = clip.bars
        held = find_held_frames(bars.entries, bars.leaves, len(clip.motion))
        for number, beats in enumerate(bars.bars):
            seconds = float((beats[3] - beats[0]) / (3 * clip.fps))
            ends = [half_up(bars.entries[number]) + 1, half_up(bars.leaves[number]) + 1, half_up(held[number])]
            rows.append(
                [clip.motion.document, number + 1, *(half_up(beat) + 1 for beat in beats), *ends, seconds, 60 / seconds]
            )
    return table(["document", "bar", "b0", "b1", "b2", "b3", "entry", "leave", "held", "beat_seconds", "bpm"], rows)


def source_labels(clips: Sequence[Clip], wanted: Sequence[str]) -> Part:
    """Motion names to write onto the clips: (document, name, first, last), frames from 1, both included."""
    rows: list[list[Any]] = []
    for clip in clips:
        if "bars" in wanted:
            rows += [
                [clip.motion.document, f"bar-{number + 1}", half_up(beats[0]) + 1, half_up(beats[3]) + 1]
                for number, beats in enumerate(clip.bars.bars)
            ]
        if "beats" in wanted:
            rows += [[clip.motion.document, "beat", frame + 1, frame + 1] for frame in whole(clip.bars.beats).tolist()]
    columns = [{"name": name, "unit": ""} for name in ("document", "name", "first", "last")]
    return Part("table", {"columns": columns, "rows": rows})


def graph_part(clips: Sequence[Clip], graph: BarGraph) -> Part:
    """Nodes: bars numbered from 1. Edges: pairs with their distance. Transforms of the jumps are in the arrays, and the
    nearest jumps, also beyond the threshold, the nearest first: bars from 0."""
    bars, edges, jumps = graph.bars, graph.edges, graph.jumps
    nearest = np.argsort(jumps.distances, kind="stable")[:MOST_JUMPS]
    nodes = [
        {
            "id": bar + 1,
            "document": clips[bars.owners[bar]].motion.document,
            "bar": int(bars.numbers[bar]) + 1,
            "first": half_up(bars.frames[bar, 0]) + 1,
            "last": half_up(bars.frames[bar, 3]) + 1,
            "beat_seconds": float(bars.seconds[bar]),
            "kept": bool(graph.kept[bar]),
        }
        for bar in range(len(bars))
    ]
    listed = [
        {"from": int(a) + 1, "to": int(b) + 1, "distance": float(d), "natural": bool(n)}
        for a, b, d, n in zip(
            edges.first[:LISTED], edges.second[:LISTED], edges.distances, edges.natural, strict=False
        )
    ]  # fmt: skip
    data = {
        "nodes": nodes,
        "edges": listed,
        "edges_in_all": len(edges),
        "threshold": graph.threshold,
        "kept": int(graph.kept.sum()),
        "removed": [bar + 1 for bar in np.flatnonzero(~graph.kept).tolist()],
    }
    arrays = {
        "pairs": np.stack([edges.first, edges.second], axis=1),
        "distances": edges.distances,
        "natural": edges.natural,
        "transforms": edges.transforms,
        "kept": graph.kept,
        "jumps": np.stack([jumps.first, jumps.second], axis=1)[nearest].astype(np.int32),
        "jump_distances": jumps.distances[nearest],
    }
    return Part("graph", data, arrays)


def graph_warnings(clips: Sequence[Clip], graph: BarGraph) -> list[str]:
    """Return warnings about a graph."""
    warnings = [
        f"{clip.motion.name}: the body jumps at frame {frame}, as after a pose of calibration; cut that off."
        for clip in clips
        if (frame := jump_of(clip)) is not None
    ]
    if graph.threshold > FAR:
        warnings.append(f"The threshold is {graph.threshold:.3f} body sizes: jumps above {FAR} slide visibly.")
    return warnings


def stage_warnings(clips: Sequence[Clip], outside: float | None, stage: Stage | None, group: bool) -> list[str]:
    """Return warnings about the places of a dance. outside: metres that it leaves its stage. group: of several."""
    warnings = []
    if stage is not None and outside:
        warnings.append(
            f"The dance leaves the stage, {stage.text}, by up to {outside:.2f} m. Use a larger stage, more clips, or "
            "raise stage_turn."
        )
    if clips[0].motion.metres is None and (stage is not None or group):
        warnings.append(
            f"{clips[0].motion.name} states no unit of length: metres are those of an adult of its proportions."
        )
    return warnings


def path_table(clips: Sequence[Clip], bars: AllBars, plan: Plan) -> Part:
    """Bars of the dance in order: which, from where, when, and how it is reached."""
    rows: list[list[Any]] = []
    for place, bar in enumerate(plan.path):
        clip = clips[bars.owners[bar]]
        reached: list[Any] = [None, None]
        if place:
            reached = [float(plan.distances[place - 1]), bool(plan.natural[place - 1])]
        span = [half_up(bars.frames[bar, 0]) + 1, half_up(bars.frames[bar, 3]) + 1]
        stretch = float((plan.grid[4 * place + 3] - plan.grid[4 * place]) / (3 * bars.seconds[bar]))
        times = [float(plan.grid[4 * place]), float(plan.grid[4 * place + 4])]
        source = [bar + 1, clip.motion.document, int(bars.numbers[bar]) + 1]
        rows.append([place + 1, *source, *span, *times, stretch, *reached])
    columns = ["position", "node", "document", "bar", "first", "last", "start", "end", "stretch", "distance", "natural"]
    return table(columns, rows)


def dance_curve(speed: Array, beats: Array, grid: Array, fps: float) -> Part:
    """Speed of the new dance with its beats and the grid."""
    step = max(1, -(-len(speed) // SHOWN))
    series = [{"name": "dance", "fps": fps, "step": step, "values": speed[::step].tolist(), "beats": beats.tolist()}]
    axes = {"x": {"name": "time", "unit": "s"}, "y": {"name": "speed", "unit": "unit/s"}}
    return Part(
        "curve", {**axes, "series": series, "grid": grid.tolist()}, {"speed": speed, "beats": beats, "grid": grid}
    )
