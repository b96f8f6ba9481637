"""Reach models: fit, synthesis, memory, and how they grow with the number of clips.

Clips are generated (`demo.reach_clips`) and in memory, as a worker has them after reading. Each size is fitted
in a process of its own, BLAS with one thread, as workers have it.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from functools import partial

from benchmarks.timing import median_seconds, report
from mcml_schemas.analyses.reach import ReachParameters, ReachWish
from mcml_service.analysis.interface import Motion, silent
from mcml_service.analysis.reach_blending.analyses import REACH
from mcml_service.analysis.reach_blending.fit import fit
from mcml_service.analysis.reach_blending.options import options_of
from mcml_service.demo.reach_clips import OLD, YOUNG, reach_clips
from tests.analysis.reach.reach_motions import motion_of

SIZES = (100, 200, 400, 800)
MANY = 2000
WISHES = [{"age": 20.0 + place, "height": 158.0 + place / 2, "hbp": 200.0 + 3 * place} for place in range(50)]


def motions(count: int) -> list[Motion]:
    """So many generated clips; 185 are the set of the paper's shape."""
    young, old = (YOUNG, OLD) if count == 185 else ((5,) * (count // 10), (5,) * (count // 10))
    return [motion_of(clip) for clip in reach_clips(1, young=young, old=old)]


def run() -> dict[str, object]:
    figures: dict[str, object] = {}
    clips = motions(185)
    for method in ("robust", "paper"):
        parameters = ReachParameters(method=method, duplicates="mean")
        options = options_of(method, duplicates="mean")
        fitting = median_seconds(partial(fit, clips, options))
        whole = median_seconds(partial(REACH.run, clips, parameters, silent))
        ready = REACH.prepare(REACH.run(clips, parameters, silent))
        make = REACH.operations["synthesize"].run
        wishes = [ReachWish(attributes=wish) for wish in WISHES]
        one = median_seconds(lambda: [make(ready, wish) for wish in wishes], 9) / len(wishes)  # noqa: B023  # called before the next turn of the loop
        figures[method] = {
            "fit": report(f"{method}: fit of 185 clips, s", fitting, "<= 2"),
            "whole": report(f"{method}: the same with all errors and parts, s", whole, "<= 2"),
            "synthesis": report(f"{method}: one synthesis with its answer, ms", 1e3 * one, "<= 5"),
        }
    figures["growth"] = {count: _measured(count) for count in SIZES}
    figures["many"] = _measured(MANY)
    return figures


def _measured(count: int) -> dict[str, float]:
    """Seconds and peak memory of a whole fit in a process of its own."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.bench_reach", str(count)],
        capture_output=True,
        text=True,
        check=True,
        env=environment,
    )
    found: dict[str, float] = json.loads(done.stdout)
    report(f"{count} clips: fit with all errors and parts, s", found["seconds"])
    report(f"{count} clips: peak of the process, MB", found["peak"], "<= 1000" if count == MANY else "")
    report(f"{count} clips: of these, before the fit began, MB", found["before"])
    report(f"{count} clips: one synthesis, ms", found["synthesis"])
    return found


def _alone(count: int) -> None:
    import resource

    clips = motions(count)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
    start = time.perf_counter()
    parts = REACH.run(clips, ReachParameters(), silent)
    seconds = time.perf_counter() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
    ready = REACH.prepare(parts)
    make = REACH.operations["synthesize"].run
    wishes = [ReachWish(attributes=wish) for wish in WISHES]
    one = median_seconds(lambda: [make(ready, wish) for wish in wishes]) / len(wishes)
    print(json.dumps({"seconds": seconds, "before": before, "peak": peak, "synthesis": 1e3 * one}))


if __name__ == "__main__":
    _alone(int(sys.argv[1]))
