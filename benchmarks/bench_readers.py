"""Whether readers take twice as long for twice as much, with gaps, warnings, repairs and faults in the files."""

from __future__ import annotations

import time

from benchmarks.reader_inputs import INPUTS, Input, read_through
from benchmarks.timing import report

FRAMES = 4_000
DOUBLINGS = 4
REPEAT = 3
MOST = 2.2
"""How many times longer an input of twice the length may take, over all doublings."""


def run() -> dict[str, object]:
    figures: dict[str, object] = {}
    for name, make in INPUTS.items():
        first = _seconds(make(FRAMES))
        last = _seconds(make(FRAMES << DOUBLINGS))
        report(f"{name}, {FRAMES << DOUBLINGS} frames: seconds of processor", last)
        # Over all doublings: what a single one takes is noise where files are small.
        ratio = (last / first) ** (1 / DOUBLINGS)
        figures[name] = report("   each doubling takes so many times longer", ratio, f"< {MOST}")
    return figures


def _seconds(made: Input) -> float:
    """The least of several: everything else that a machine does makes it longer."""
    times = []
    for _ in range(REPEAT):
        start = time.process_time()
        read_through(made)
        times.append(time.process_time() - start)
    return min(times)
