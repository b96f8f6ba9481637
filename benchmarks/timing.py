"""How times are taken."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable


def median_seconds(action: Callable[[], object], repeat: int = 5) -> float:
    """Median wall time of an action; its first, warming run is not counted."""
    action()
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def report(what: str, value: float, target: str = "") -> float:
    print(f"   {what:<66} {value:10.4g}   {target}", flush=True)
    return value
