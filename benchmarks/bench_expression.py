"""Expression spaces: all stages at the paper's size, operations, 96,000 frames, and the figures of the docs.

Takes are generated (`demo.face_takes`) and in memory, as a worker has them after reading. BLAS has one thread,
as in workers. The large space is built in a process of its own. `python -m benchmarks.bench_expression tables` prints
the tables of docs/analyses/expression.md.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.timing import median_seconds, report
from mcml_schemas.analyses.expression import (
    ExpressionCandidateChoice,
    ExpressionLevelChoice,
    ExpressionParameters,
    ExpressionStride,
)
from mcml_schemas.analyses.expression_paths import (
    ExpressionPathWish,
    ExpressionPlayback,
    ExpressionRefinement,
)
from mcml_service.analysis.expression_space.analyses import EXPRESSION
from mcml_service.analysis.interface import Motion, Parts, silent
from mcml_service.demo.face_takes import face_takes
from tests.analysis.expression.face_motions import motion_of

LARGE = 96_000
STEPS = (3, 5, 8)


def takes(repeats: int = 1, **options: Any) -> list[Motion]:
    """Takes with head motion and noise; about 2,400 frames a repeat."""
    return [motion_of(take) for take in face_takes(1, repeats=repeats, **{"head": True, "noise": 0.1, **options})]


def run() -> dict[str, object]:
    figures: dict[str, object] = {}
    for method, wanted in (("robust", "<= 20"), ("paper", "<= 60")):
        found = _alone("stages", method)
        for stage, seconds in found["stages"].items():
            report(f"{method}: {stage}, s", seconds)
        report(f"{method}: {found['frames']} frames, all stages, s", found["seconds"], wanted)
        for name, ms in found["operations"].items():
            report(f"{method}: {name}, ms", ms, "" if name == "prepare" else "<= 50")
        figures[method] = found
    found = _alone("large")
    report(f"{found['frames']} frames, all stages and parts, s", found["seconds"], "<= 180")
    report(f"{found['frames']} frames, peak of the process, MB", found["peak"], "<= 2000")
    report(f"{found['frames']} frames, of these before it began, MB", found["before"])
    figures["large"] = found
    return figures


def _alone(*arguments: str) -> dict[str, Any]:
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "benchmarks.bench_expression", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


class _Stages:
    """Seconds of each stage, from the calls of progress."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._stage, self._since = "", time.perf_counter()

    def __call__(self, stage: str, share: float) -> None:
        now = time.perf_counter()
        if self._stage:
            self.seconds[self._stage] = self.seconds.get(self._stage, 0.0) + now - self._since
        self._stage, self._since = stage, now


def _stages(method: str) -> None:
    motions = takes(gaps=0.01)
    stages = _Stages()
    start = time.perf_counter()
    parts = EXPRESSION.run(motions, ExpressionParameters(method=method), stages)
    seconds = time.perf_counter() - start
    frames = parts["space"].data["summary"]["frames"]
    found = {"frames": frames, "seconds": seconds, "stages": stages.seconds, "operations": _operations(parts)}
    print(json.dumps(found))


def _operations(parts: Parts) -> dict[str, float]:
    """Milliseconds of operations, the slowest of several calls each."""
    found: dict[str, float] = {}

    def timed(name: str, ready: Any, wish: Any) -> Any:
        ms = 1e3 * median_seconds(lambda: EXPRESSION.operations[name].run(ready, wish), 5)
        found[name] = max(found.get(name, 0.0), ms)
        return EXPRESSION.operations[name].run(ready, wish)

    start = time.perf_counter()
    ready = EXPRESSION.prepare(parts)
    found["prepare"] = 1e3 * (time.perf_counter() - start)
    timed("points", ready, ExpressionStride())
    levels = parts["space"].data["summary"]["levels"]
    for level in range(levels):
        shown = timed("level", ready, ExpressionLevelChoice(level=level)).value.candidates
        for one in shown[:: max(1, len(shown) // 5)]:
            timed("neighbours", ready, ExpressionCandidateChoice(level=level, document=one.document, frame=one.frame))
    keys = [{"document": key.document, "frame": key.frame} for key in _chain(ready)]
    parent = timed("path", ready, ExpressionPathWish(level=0, keys=keys))
    for level in STEPS:
        child = EXPRESSION.prepare({**parts, **parent.keep})
        timed("refine", child, ExpressionRefinement(level=level, rule="paper"))
        parent = timed("refine", child, ExpressionRefinement(level=level, auto=True))
    child = EXPRESSION.prepare({**parts, **parent.keep})
    timed("playback", child, ExpressionPlayback())
    return found


def _chain(ready: Any) -> list[Any]:
    """Up to four candidates of level 0, each linked to the next, by the longest links."""
    level: Any = EXPRESSION.operations["level"].run(ready, ExpressionLevelChoice(level=0)).value
    keys = [level.links[-1].a, level.links[-1].b]
    for link in reversed(level.links):
        ends = {link.a, link.b}
        if len(keys) < 4 and keys[-1] in ends and not (ends - {keys[-1]}) & set(keys):
            keys += ends - {keys[-1]}
    return [level.candidates[key] for key in keys]


def _large() -> None:
    import resource

    kept: list[Motion] = []
    for seed in range(1, LARGE // 2000):
        # A set at a time, of which only what a worker would have stays.
        for take in face_takes(seed, head=True, noise=0.1):
            if sum(map(len, kept)) + len(take.still) <= LARGE:
                kept.append(replace(motion_of(take), document=f"{seed:02d}-{take.name}"))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
    stages = _Stages()
    start = time.perf_counter()
    parts = EXPRESSION.run(kept, ExpressionParameters(), stages)
    seconds = time.perf_counter() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
    summary = parts["space"].data["summary"]
    found = {"frames": summary["frames"], "seconds": seconds, "stages": stages.seconds, "before": before, "peak": peak}
    print(json.dumps({**found, "r": summary["r"], "stress": summary["stress"], "levels": summary["levels"]}))


def tables() -> None:
    """Threshold curves, levels and fit of the generated set, as Markdown."""
    for name, method, noise in (("paper, no noise", "paper", 0.0), ("paper", "paper", 0.1), ("robust", "robust", 0.1)):
        parts = EXPRESSION.run(takes(noise=noise), ExpressionParameters(method=method), silent)
        summary = parts["space"].data["summary"]
        print(f"\n{name}: tau {summary['tau_mm']:.1f}, connecting {summary['connecting_tau_mm']:.1f}")
        print(f"speed {summary['speed_mm_s']:.0f}, warnings {summary['warnings']}")
        for row in parts["tau"].data["rows"]:
            cells = [
                f"{row['tau']:.1f}",
                f"{row['broken']:.4f}",
                f"{row['r']:.4f}",
                f"{row['stress']:.3f}",
                row["components"],
            ]
            print("|", " | ".join(map(str, [*cells, f"{row['degree']:.0f}", f"{row['stretch']:.3f}"])), "|")
        for part in ("levels", "fit"):
            print(part, [column["name"] for column in parts[part].data["columns"]])
            for row in parts[part].data["rows"]:
                print("|", " | ".join(f"{cell:.4g}" if isinstance(cell, float) else str(cell) for cell in row), "|")
        print("expressions near whose extreme a candidate of level 0 lies:", _extremes(parts))


def _extremes(parts: Parts) -> int:
    """Of how many takes a candidate of level 0 lies between the ends of the highest third of its movement."""
    ready = EXPRESSION.prepare(parts)
    state = np.linalg.norm(ready.positions - ready.positions[ready.values["neutral"]], axis=2)
    moved = np.sqrt(np.nansum(state**2, axis=1))
    found = set()
    for frame in ready.ground.candidates[0].tolist():
        own = ready.take == ready.take[frame]
        if moved[frame] >= 0.8 * moved[own].max():
            found.add(int(ready.take[frame]))
    return len(found)


if __name__ == "__main__":
    work: dict[str, Callable[..., None]] = {"stages": _stages, "large": _large, "tables": tables}
    work[sys.argv[1]](*sys.argv[2:])
