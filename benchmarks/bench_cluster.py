"""A graph of 2,000 bars by one and by two workers, which read their clips from the store: of this host, and of a Dask
cluster over TLS.

Of Dask, processor seconds of each worker's process; wall time beside them, which says little where workers share the
processors with each other, the scheduler and this program.
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from distributed import Client, LocalCluster, Security

from benchmarks.timing import report
from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.analysis.interface import Parts
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.jobs.dask_workers import DaskCrew, DaskExecutor
from mcml_service.jobs.host_workers import HostWorkers
from mcml_service.jobs.worker import Outcome, Refused, Task, work_on
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
            key = tx.projects.get_or_add("dance")
            job = tx.jobs.add(key, "motion-graph", "graph", "demo", inputs, {}, runner="benchmark")
        task = Task((database.url, None), job, "benchmark", "motion-graph", inputs, {})
        results = [made(task, count, figures) for made in (_by_host, _by_dask) for count in (1, 2)]
        database.close()
    alone, *others = (result["graph"].arrays for result in results)
    figures["same"] = all(np.array_equal(alone[name], other[name]) for name in alone for other in others)
    report(f"{len(alone['pairs']):,} edges, the same by all", float(figures["same"]), "1")
    figures["share"] = report("busier of two / one alone", figures["busiest"][2] / figures["busiest"][1], "<= 0.6")
    return figures


def _by_host(task: Task, workers: int, figures: dict[str, Any]) -> Parts:
    with HostWorkers(workers, 4 << 30) as pool:
        found = []
        for _ in range(ROUNDS + 1):
            start = time.perf_counter()
            parts = _parts(pool.submit(work_on, task, pool.crew).result())
            found.append(time.perf_counter() - start)
    figures[f"wall of {workers} here"] = report(f"{workers} at work here: wall, s", min(found[1:]))
    return parts


def _by_dask(task: Task, workers: int, figures: dict[str, Any]) -> Parts:
    """The last of several rounds, of which the one with the least work of the busiest counts."""
    security = Security.temporary()
    found: list[tuple[float, list[float], float]] = []
    with (
        LocalCluster(
            n_workers=workers, threads_per_worker=1, host="127.0.0.1", protocol="tls", security=security,
            dashboard_address=":0", silence_logs=50,
        ) as cluster,
        Client(cluster, set_as_default=False, security=security) as client,
    ):  # fmt: skip
        executor = DaskExecutor(client)
        for number in range(ROUNDS + 1):
            before, start = client.run(_used), time.perf_counter()
            parts = _parts(executor.submit(work_on, task, DaskCrew()).result())
            wall, after = time.perf_counter() - start, client.run(_used)
            if number:
                own = sorted(after[name] - before[name] for name in after)
                found.append((own[-1], own, wall))
    busiest, own, wall = min(found)
    figures.setdefault("busiest", {})[workers] = busiest
    words = " and ".join(f"{seconds:.1f}" for seconds in own)
    figures[f"wall of {workers}"] = report(f"{workers} of Dask ({words} s of processor time): wall, s", wall)
    return parts


def _parts(outcome: Outcome) -> Parts:
    if isinstance(outcome, Refused):
        raise SystemExit(str(outcome.problem))
    return outcome


def _used() -> float:
    return sum(os.times()[:2])
