"""A reader beside eight clients of his own address whose expressions are made to hurt.

`MCML_LIBRARIES`: folders of BVH files, as for `library`; the first one is asked.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections import Counter
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from random import Random

import httpx

from benchmarks.bench_library import store_of
from benchmarks.library import serving
from benchmarks.timing import report
from tests.hostile.hostile_expressions import hostile_expression
from tests.hostile.test_hostile_questions import BOMBS, Resident

CLIENTS = 8
BY_CHANCE = 100
"""Expressions besides the chosen ones."""
EVERY = 0.1
QUESTION = "count(//frame)"


def run() -> dict[str, object]:
    folder = os.environ.get("MCML_LIBRARIES", "").split(":")[0]
    if not folder:
        sys.exit("MCML_LIBRARIES names no folder of BVH files")
    chance = Random(7)
    expressions = [*BOMBS.values(), *(hostile_expression(chance) for _ in range(BY_CHANCE))]
    chance.shuffle(expressions)
    with serving(f"sqlite:///{store_of(Path(folder))}") as (pid, port), Resident(pid) as resident:
        with httpx.Client(base_url=f"http://127.0.0.1:{port}/api/v1", timeout=300) as client:
            client.get("/xpath", params={"q": QUESTION}).raise_for_status()
            with ThreadPoolExecutor(CLIENTS) as pool:
                asked = [pool.submit(client.post, "/xpath", json={"q": text}) for text in expressions]
                took = _read(client, asked)
        answers = Counter(str(one.result().status_code) for one in asked)
    report("seconds of it", len(took) * EVERY)
    report("reader, median, ms", statistics.median(took))
    report("reader, 99th percentile, ms", statistics.quantiles(took, n=100)[98], "<= 50")
    report("server and its processes, at most, MiB", resident.most / (1 << 20), "<= 2048")
    print(f"   hostile expressions by status: {dict(answers)}")
    return {"reader": sorted(took), "resident": resident.most, "statuses": dict(answers)}


def _read(client: httpx.Client, asked: list[Future[httpx.Response]]) -> list[float]:
    """Milliseconds of each question of the reader, until all others are answered."""
    took = []
    while not all(one.done() for one in asked):
        begin = time.perf_counter()
        client.get("/xpath", params={"q": QUESTION}).raise_for_status()
        seconds = time.perf_counter() - begin
        took.append(seconds * 1000)
        time.sleep(max(0.0, EVERY - seconds))
    return took
