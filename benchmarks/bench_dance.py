"""Beats of an hour of motion, a graph of 500 bars, three minutes of dance: seconds and memory.

`python -m benchmarks.bench_dance` prints the tables of docs/analyses/dance.md instead: generated clips that no test
uses, and the real dance clips beside the repository.
"""

from __future__ import annotations

import os
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.timing import median_seconds, report
from mcml.motion.skeleton import Convention
from mcml_schemas.analyses.dance import BeatsParameters, DanceParameters, GraphParameters
from mcml_service.analysis.dance.analyses import BEATS, DANCE, MOTION_GRAPH
from mcml_service.analysis.dance.figure import figure_of
from mcml_service.analysis.dance.metrics import mean_or_none, nearest, watch
from mcml_service.analysis.interface import Motion, Part, Parts, silent
from mcml_service.demo.dance_clips import Style, Truth
from tests.analysis.dance.motions import BEAT_STYLES, STYLES, generated, read_file, resampled
from tests.builders import assign

REPEAT = 3


def run() -> dict[str, object]:
    hour = _hour()
    bars = [generated("step", f"{seed}", bars=50, seed=seed, tempo=100.0 + 3 * seed)[0] for seed in range(10)]
    dance = DanceParameters.model_validate({"bpm": 120, "bars": 90})
    frames = len(DANCE.run(bars[:2], dance, silent)["speed"].arrays["speed"])
    tasks: dict[str, tuple[str, Callable[[], object], str]] = {
        "beats": (
            f"beats of an hour at 120 Hz, {len(hour):,} frames: s",
            lambda: BEATS.run([hour], BeatsParameters(), silent),
            "<= 10",
        ),
        "graph": ("graph of 500 bars: s", lambda: MOTION_GRAPH.run(bars, GraphParameters(), silent), "<= 5"),
        "dance": (
            f"three minutes of dance with all figures, {frames:,} frames: s",
            lambda: DANCE.run(bars[:2], dance, silent),
            "<= 3",
        ),
    }
    tasks["ten minutes"] = (
        "ten minutes of dance of 200 bars on a stage, with all figures: s",
        lambda: DANCE.run(bars[:4], dance.model_copy(update={"bars": 300, "stage": 3.0}), silent),
        "<= 10",
    )
    figures: dict[str, object] = {}
    for name, (what, task, target) in tasks.items():
        figures[name] = report(what, median_seconds(task, REPEAT), target)
        figures[f"{name}_megabytes"] = report("   peak of memory above its clips: MB", _peak(task))
    return figures


def _hour() -> Motion:
    """One clip of ten minutes, six times after itself."""
    motion, _ = generated("step", fps=120.0, bars=280, tempo=112.0)
    rotations = np.concatenate([motion.rotations] * 6)[: 3600 * 120]
    translations = np.concatenate([motion.translations] * 6)[: 3600 * 120]
    return replace(motion, rotations=rotations, translations=translations)


def _peak(task: Callable[[], object]) -> float:
    tracemalloc.start()
    task()
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    return peak


def _records(part: Part) -> list[dict[str, object]]:
    names = [column["name"] for column in part.data["columns"]]
    return [dict(zip(names, row, strict=True)) for row in part.data["rows"]]


def _hits(motion: Motion, truth: Truth, **parameters: object) -> tuple[float, float, float]:
    """Precision, recall within a frame or a sixtieth of a second, and the error of the period."""
    parts = BEATS.run([motion], BeatsParameters.model_validate(parameters), silent)
    found = np.array([row["seconds"] for row in _records(parts["beats"])])
    within = max(1 / motion.fps, 1 / 60) + 1e-9
    met = int((nearest(truth.beats, found) <= within).sum())
    period = _records(parts["clips"])[0]["period"]
    return met / len(found), met / len(truth.beats), abs(float(str(period)) / truth.period - 1)


def generated_table() -> str:
    """Beats of clips of seeds and dancers that no test and no choice of a parameter has seen: 10 clips a cell."""
    lines = ["| style | precision, least of 9 cells | recall, least | period, greatest error |", "|---|---|---|---|"]
    for style in STYLES:
        cells = []
        for fps in (30.0, 60.0, 120.0):
            for tempo in (80.0, 110.0, 145.0):
                clips = [generated(style, fps=fps, tempo=tempo, bars=12, seed=s, dancer=s) for s in range(100, 110)]
                cells.append([_hits(motion, truth) for motion, truth in clips])
        measured = np.array(cells)
        precision, recall = measured[..., 0].mean(axis=1).min(), measured[..., 1].mean(axis=1).min()
        lines.append(f"| `{style}` | {precision:.3f} | {recall:.3f} | {100 * measured[..., 2].max():.2f} % |")
    return "\n".join(lines)


def ways_table() -> str:
    """The same clips at 60 and 120 frames a second with the choices of the thesis: precision, recall."""
    thesis: dict[str, object] = {"locate": False, "smooth": 0, "difference": "forward"}
    ways: dict[str, dict[str, object]] = {
        "default": {},
        "`locate=false`": {"locate": False},
        "thesis: also `smooth=0 difference=forward`, k2 of its equation 2": thesis,
    }
    lines = [f"| | {' | '.join(f'`{style}`' for style in BEAT_STYLES)} |", "|---|" + "---|" * len(BEAT_STYLES)]
    for name, parameters in ways.items():
        cells = []
        for style in BEAT_STYLES:
            found = []
            for fps in (60.0, 120.0):
                depth = {"k2": 1 / (2 * round(fps / 3) + 1)} if parameters is thesis else {}
                for seed in range(100, 110):
                    motion, truth = generated(style, fps=fps, tempo=110.0, bars=12, seed=seed, dancer=seed)
                    found.append(_hits(motion, truth, **parameters, **depth))
            precision, recall, _ = np.mean(found, axis=0)
            cells.append(f"{precision:.2f}, {recall:.2f}")
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def synthesis_table() -> str:
    """New dances of generated clips: beats on the grid, beats inside transitions, speed of joints beside the source."""
    lines = [
        "| style | inner beats within a frame | held beat, greatest distance s | beat after a jump found "
        "| rotation speed / source's at its rate, hold, classic | beats in transitions, hold, classic |",
        "|---|---|---|---|---|---|",
    ]
    for style in BEAT_STYLES:
        inner, held, after, inside = [], [], [], np.zeros(2, dtype=int)
        speeds: dict[str, list[float]] = {"hold": [], "classic": []}
        for fps in (30.0, 60.0, 120.0):
            for bpm in (90.0, 120.0, 140.0):
                parts = _random_dance(style, fps, bpm)
                grid, found = parts["speed"].arrays["grid"], parts["speed"].arrays["beats"]
                inner += (nearest(np.concatenate([grid[1::4], grid[2::4]]), found) <= 1 / fps + 1e-6).tolist()
                jumps = 4 * np.array([int(str(row["position"])) - 1 for row in _records(parts["transitions"])])
                held += nearest(grid[jumps - 1], found).tolist()
                after += (nearest(grid[jumps], found) <= 0.12).tolist()
                metrics = dict(parts["metrics"].data["rows"])
                inside += [metrics["beats_in_transitions"], metrics["classic_beats_in_transitions"]]
                classic = dict(_random_dance(style, fps, bpm, "classic")["metrics"].data["rows"])
                for blend, values in (("hold", metrics), ("classic", classic)):
                    source = values["source_greatest_rotation_speed"] * values["greatest_rate"]
                    speeds[blend].append(values["greatest_rotation_speed"] / source)
        lines.append(
            f"| `{style}` | {np.mean(inner):.3f} | {max(held):.3f} | {np.mean(after):.3f} "
            f"| {max(speeds['hold']):.2f}, {max(speeds['classic']):.2f} | {inside[0]}, {inside[1]} |"
        )
    return "\n".join(lines)


def _random_dance(style: Style, fps: float, bpm: float, blend: str = "hold") -> Parts:
    clips = [
        generated(style, "1", fps=fps, bars=12, seed=101, dancer=7)[0],
        generated(style, "2", fps=fps, bars=12, seed=102, dancer=7, tempo=126.0)[0],
    ]
    parameters = {"bpm": bpm, "bars": 40, "strategy": "random", "seed": 1, "blend": blend}
    return DANCE.run(clips, DanceParameters.model_validate(parameters), silent)


def real_clips() -> list[Motion]:
    """The dance clips of the data folder; none where it is not here."""
    stated = os.environ.get("MCML_SHARED")
    data = (Path(stated) if stated else Path(__file__).resolve().parents[2] / "shared") / "data"
    paths = [
        *sorted((data / "bvh" / "dance").glob("*.bvh")),
        *sorted((data / "bvh" / "exporters").glob("rokoko_jesse_dance.bvh")),
        *sorted((data / "asfamc" / "dance").glob("*.amc")),
        *sorted((data / "asfamc" / "cmu131_dance").glob("*.amc")),
        *sorted((data / "c3d" / "dance").glob("*.c3d")),
        *sorted((data / "trc" / "dance").glob("*.trc")),
    ]
    return [read_file(path, f"{number:02}") for number, path in enumerate(paths)]


def real_table(clips: list[Motion]) -> str:
    """Beats, periods, bars and agreement with itself at 30 frames a second of each clip."""
    lines = [
        "| clip | s | fps | minima | refused F1, F2, F3 | beats | tempo, rivals | bars detected | tracked | auto "
        "| same at 30 fps |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for motion in clips:
        ways = {
            which: BEATS.run([motion], BeatsParameters.model_validate({"beats_from": which}), silent)
            for which in ("detected", "tracked", "auto")
        }
        row = {which: _records(parts["clips"])[0] for which, parts in ways.items()}
        own = row["detected"]
        refused = ", ".join(str(own[f"refused_{name}"]) for name in ("F1", "F2", "F3"))
        peaks = own["peaks"]
        tempi = ", ".join(f"{peak['bpm']:.1f}" for peak in peaks) if isinstance(peaks, list) else ""
        slow = BEATS.run([resampled(motion, 30.0)], BeatsParameters(beats_from="detected"), silent)
        one, other = (
            np.array([r["seconds"] for r in _records(p["beats"])], dtype=float) for p in (ways["detected"], slow)
        )
        same = min((nearest(one, other) <= 1 / 30).sum(), (nearest(other, one) <= 1 / 30).sum()) if len(other) else 0
        bars = " | ".join(str(row[which]["bars"]) for which in ("detected", "tracked"))
        lines.append(
            f"| {motion.name} | {len(motion) / motion.fps:.1f} | {motion.fps:.0f} | {own['candidates']} | {refused} "
            f"| {own['beats']} | {tempi} | {bars} | {row['auto']['bars']} {row['auto']['beats_from']} "
            f"| {same} of {max(len(one), len(other))} |"
        )
    return "\n".join(lines)


def blend_table(clips: list[Motion]) -> str:
    """Speed variance, peak, beats and foot skate inside transitions of both blends, on random dances of one clip each.

    Bars overlap and beats are tracked, so that short clips have bars at all.
    """
    lines = [
        "| clip | bars kept | threshold | jumps | variance hold / classic | lower | peak hold / classic | lower "
        "| beats inside | skate hold / classic / outside | rotation speed / source's at its rate, hold, classic |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for motion in clips:
        if motion.skeleton.joints[0].convention is Convention.MARKER:
            continue
        options = {"beats_from": "tracked", "stride": 1}
        graph = _graph_of(motion, options)
        if graph is None or graph.data["kept"] < 2:
            continue
        bpm = 60 / float(np.median([node["beat_seconds"] for node in graph.data["nodes"]]))
        while bpm < 60:
            bpm *= 2
        wish = {**options, "bpm": bpm, "bars": 64, "strategy": "random", "seed": 1}
        parts = DANCE.run([motion], DanceParameters.model_validate(wish), silent)
        rows, metrics = _records(parts["transitions"]), dict(parts["metrics"].data["rows"])
        variance, peak = (
            np.array([[row[name], row[f"classic_{name}"]] for row in rows], dtype=float)
            for name in ("speed_variance", "speed_peak")
        )
        skate = [metrics[f"{name}foot_skate_in_transitions"] for name in ("", "classic_")]
        played_on = DANCE.run([motion], DanceParameters.model_validate({**wish, "blend": "classic"}), silent)
        turns = [
            values["greatest_rotation_speed"] / (values["source_greatest_rotation_speed"] * values["greatest_rate"])
            for values in (metrics, dict(played_on["metrics"].data["rows"]))
        ]
        lines.append(
            f"| {motion.name} | {graph.data['kept']} | {graph.data['threshold']:.3f} | {len(rows)} "
            f"| {variance[:, 0].mean():.3f} / {variance[:, 1].mean():.3f} | {_share(variance)} "
            f"| {peak[:, 0].mean():.2f} / {peak[:, 1].mean():.2f} | {_share(peak)} "
            f"| {metrics['beats_in_transitions']} / {metrics['classic_beats_in_transitions']} "
            f"| {skate[0]:.3f} / {skate[1]:.3f} / {metrics['foot_skate_outside']:.3f} "
            f"| {turns[0]:.2f}, {turns[1]:.2f} |"
        )
    return "\n".join(lines)


SETS = {
    "A, B, C_test": ("A_test", "B_test", "C_test"),
    "131_01 to 03": ("131_01", "131_02", "131_03"),
    "60_10, 61_10": ("60_10_scaled", "61_10_scaled"),
    "Gangnam-Style": ("Gangnam-Style",),
    "rokoko_jesse_dance": ("rokoko_jesse_dance",),
    "charleston1, 2, lambada": ("charleston1", "charleston2", "lambada"),
}
WAYS: dict[str, dict[str, object]] = {
    "`novelty=0`": {"novelty": 0},
    "default": {},
    "`stage=3`": {"stage": 3},
    "`stage=3 lock_feet=true`": {"stage": 3, "lock_feet": True},
}


def ten_minutes_table(clips: list[Motion]) -> str:
    """Dances of 300 bars at 120 a minute, of overlapping bars of clips of one body, as they are stored."""
    lines = [
        "| clips | parameters | bars used | most uses | farthest m | alignment music, motion "
        "| foot slide in transitions, elsewhere, sources | s |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, members in SETS.items():
        own = [replace(clip, skeleton=assign(clip.skeleton)) for clip in clips if clip.name in members]
        figures = [figure_of(motion.skeleton, motion.translations) for motion in own]
        slides = [
            watch(figure, motion.translations, motion.rotations, motion.fps).foot_speed
            for figure, motion in zip(figures, own, strict=True)
        ]
        source = mean_or_none(np.concatenate(slides)) if slides else None
        for way, options in WAYS.items():
            if not own:
                continue
            wish = {"bpm": 120, "bars": 300, "stride": 1, "pulse": "1", **options}
            begun = perf_counter()
            parts = DANCE.run(own, DanceParameters.model_validate(wish), silent)
            seconds = perf_counter() - begun
            values = dict(parts["metrics"].data["rows"])
            slide = ", ".join(
                "–" if value is None else f"{value:.3f}"
                for value in (values["foot_skate_in_transitions"], values["foot_skate_outside"], source)
            )
            lines.append(
                f"| {name} | {way} | {values['bars_used']} of {values['bars_available']} | {values['most_uses']} "
                f"| {values['farthest_from_centre']:.1f} "
                f"| {values['beat_align_music']:.3f}, {values['beat_align_motion']:.3f} | {slide} | {seconds:.0f} |"
            )
    return "\n".join(lines)


GROUPS: dict[str, dict[str, object] | None] = {
    "one": None,
    "2, unison": {"count": 2},
    "3, unison": {"count": 3},
    "2, canon": {"count": 2, "mode": "canon"},
    "3, canon": {"count": 3, "mode": "canon"},
    "2, free": {"count": 2, "mode": "free"},
    "3, free": {"count": 3, "mode": "free"},
}


def group_table(clips: list[Motion]) -> str:
    """Five minutes of several dancers: 150 bars at 120 a minute on a stage of 4 m radius, else as in ten minutes."""
    lines = [
        "| clips | dancers | least distance m | outside m | most uses of each | alignment music, of each "
        "| alignment motion, of each | s |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, members in SETS.items():
        own = [replace(clip, skeleton=assign(clip.skeleton)) for clip in clips if clip.name in members]
        for group, wish in GROUPS.items() if own else ():
            options = {"bpm": 120, "bars": 150, "stride": 1, "pulse": "1", "stage": 4, "dancers": wish}
            begun = perf_counter()
            parts = DANCE.run(own, DanceParameters.model_validate(options), silent)
            seconds = perf_counter() - begun
            values = dict(parts["metrics"].data["rows"])
            dancers = _records(parts["dancers"]) if wish else [values]
            cells = [
                ", ".join(f"{dancer[column]:{form}}" for dancer in dancers)
                for column, form in (("most_uses", ""), ("beat_align_music", ".3f"), ("beat_align_motion", ".3f"))
            ]
            least = f"{values['least_distance']:.2f}" if wish else "–"
            figures = f"| {least} | {values['outside_stage']:.1f} | {' | '.join(cells)} | {seconds:.0f} |"
            lines.append(f"| {name} | {group} {figures}")
            print(lines[-1], flush=True)
    return "\n".join(lines)


def _graph_of(motion: Motion, options: dict[str, object]) -> Part | None:
    if not BEATS.run([motion], BeatsParameters.model_validate(options), silent)["bars"].data["rows"]:
        return None
    return MOTION_GRAPH.run([motion], GraphParameters.model_validate(options), silent)["graph"]


def _share(pairs: np.ndarray) -> str:
    """How often the first of a pair is the smaller."""
    return f"{100 * (pairs[:, 0] < pairs[:, 1]).mean():.0f} %"


if __name__ == "__main__":
    real = real_clips()
    for table in (
        generated_table(),
        ways_table(),
        synthesis_table(),
        real_table(real),
        blend_table(real),
        ten_minutes_table(real),
        group_table(real),
    ):
        print(table, end="\n\n")
