"""A graph of 2,000 bars by one and by two workers of a Dask cluster over TLS, which read their clips from the store.

Processor seconds of each worker's process; wall time beside them, which says little where workers share the processors
with each other, the scheduler and this program.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np

from benchmarks.timing import report
from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.analysis.interface import Part, Parts
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.jobs.cluster import Cluster
from mcml_service.jobs.worker import Refused, on_dask
from mcml_service.settings import Settings
from mcml_service.storage.core.tables import document
from mcml_service.storage.database import Database

CLIPS, BARS = 40, 50
ROUNDS = 2


def run() -> dict[str, Any]:
    figures: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        database = Database(f"sqlite:///{Path(folder) / 'store.db'}")
        database.migrate()
        clips = [dance_clip("step", name=f"d{n}", bars=BARS, seed=n, tempo=100.0 + n).clip for n in range(CLIPS)]
        add_clips(database, Settings(), "dance", clips, (), "")
        with database.read() as tx:
            inputs = [{"document": row.uuid, "revision": 1} for row in tx.connection.execute(document.select())]
        with database.write() as tx:
            job = tx.jobs.add(tx.projects.get_or_add("dance"), "motion-graph", "graph", "demo", inputs, {})
        results = {count: _measured(database, job, inputs, count, figures) for count in (1, 2)}
        database.close()
    alone, both = (results[count]["graph"].arrays for count in (1, 2))
    figures["same"] = all(np.array_equal(alone[name], both[name]) for name in alone)
    report(f"{len(alone['pairs']):,} edges, the same by both", float(figures["same"]), "1")
    figures["share"] = report("busier of two / one alone", figures["busiest"][2] / figures["busiest"][1], "<= 0.6")
    return figures


def _measured(
    database: Database, job: str, inputs: list[dict[str, Any]], workers: int, figures: dict[str, Any]
) -> Parts:
    """The last of several rounds, of which the one with the least work of the busiest counts."""
    cluster = Cluster(database, Settings(job_workers=workers))
    client = cluster.client()
    task = partial(on_dask, (database.url, None), job, "motion-graph", inputs, {})
    found: list[tuple[float, list[float], float]] = []
    for number in range(ROUNDS + 1):
        before, start = client.run(_used), time.perf_counter()
        outcome = client.submit(task, key=f"graph {workers} {number}", pure=False).result()
        wall, after = time.perf_counter() - start, client.run(_used)
        if isinstance(outcome, Refused):
            raise SystemExit(str(outcome.problem))
        if number:
            own = sorted(after[name] - before[name] for name in after)
            found.append((own[-1], own, wall))
    cluster.close()
    busiest, own, wall = min(found)
    figures.setdefault("busiest", {})[workers] = busiest
    words = " and ".join(f"{seconds:.1f}" for seconds in own)
    figures[f"wall of {workers}"] = report(f"{workers} at work ({words} s of processor time): wall, s", wall)
    return cast(Mapping[str, Part], outcome)


def _used() -> float:
    return sum(os.times()[:2])
