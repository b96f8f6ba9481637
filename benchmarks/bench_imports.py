"""Imports of thousands of short clips: in one call, file by file, over HTTP; what the last of many costs.

`MCML_LIBRARIES`: folders of BVH files, separated by colons. Stores are made in the folder for temporary files, and go.
Wall time depends on who else is at work: processor time is told beside it. An import derives no bodies; a server that
does so is measured beside one that does not, in turn, and `bodies` measures what deriving takes.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import httpx

from benchmarks.library import forget_skeletons, serving
from benchmarks.timing import report
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.importing import encode_clip
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

ROUNDS = 3
TOGETHER = 512
"""Files of one upload."""

ALONE = 500
"""Files that are imported one by one."""

AT_A_TIME = 1000
"""Files of a call where a library is larger than that."""


def run() -> dict[str, object]:
    folders = [Path(part) for part in os.environ.get("MCML_LIBRARIES", "").split(":") if part]
    if not folders:
        sys.exit("MCML_LIBRARIES names no folder of BVH files")
    found: dict[str, object] = {}
    for folder in folders:
        paths = sorted(folder.glob("*.bvh"))
        print(f"   -- {folder.name}: {len(paths):,} files, {sum(path.stat().st_size for path in paths) / 1e6:,.0f} MB")
        found[folder.name] = _growth(paths) if len(paths) > 4 * AT_A_TIME else _library(paths)
    return found


def _library(paths: list[Path]) -> dict[str, Any]:
    figures: dict[str, Any] = {}
    for round_ in range(ROUNDS):
        with _store() as database:
            wall, own, readers = _timed(lambda: _imported(database, paths))
            figures[f"together {round_}"] = report(
                f"one call, s (importer {own:.1f}, readers {readers:.1f} of processor time)", wall
            )
            size = database.dialect.size
            with database.read() as tx:
                sizes = size(tx.connection)
    text = sum(path.stat().st_size for path in paths)
    figures["size"] = report("store without uploads / text", (sizes["total"] - sizes["uploads"]) / text)
    with _store() as database, patch.object(encode_clip, "thumbnail_of", lambda *_: None):
        wall, own, readers = _timed(lambda: _imported(database, paths))
    figures["without thumbnails"] = report(
        f"without thumbnails, s (importer {own:.1f}, readers {readers:.1f} of processor time)", wall
    )
    some = paths[:: max(1, len(paths) // ALONE)]
    with _store() as database:
        wall, own, _ = _timed(lambda: _one_by_one(partial(_imported, database), [[path] for path in some]))
    figures["alone"] = report(
        f"one by one, ms a file ({1000 * own / len(some):.1f} of processor time)", _each(wall, some)
    )
    groups = [paths[at : at + TOGETHER] for at in range(0, len(paths), TOGETHER)]
    for derive in ("no", "yes") * ROUNDS:
        with _served(derive) as client:
            wall, _, _ = _timed(partial(_one_by_one, partial(_uploaded, client), groups))
            words = f"over HTTP in {len(groups)} uploads, bodies derived meanwhile: {derive}, s"
            figures.setdefault(f"uploads {derive}", []).append(report(words, wall))
    with _served() as client:
        wall, _, _ = _timed(lambda: _one_by_one(partial(_uploaded, client), [[path] for path in some]))
    figures["alone over HTTP"] = report("over HTTP one by one, ms a file", _each(wall, some))
    return figures


def _growth(paths: list[Path]) -> dict[str, Any]:
    """What a file costs in processor time while the store grows."""
    costs: list[float] = []
    start = time.perf_counter()
    with _store() as database:
        for at in range(0, len(paths) - AT_A_TIME + 1, AT_A_TIME):
            wall, own, readers = _timed(partial(_imported, database, paths[at : at + AT_A_TIME]))
            costs.append(1000 * (own + readers) / AT_A_TIME)
            if at // AT_A_TIME % 5 == 0:
                print(
                    f"      {at + AT_A_TIME:,}: {wall:.1f} s, {costs[-1]:.2f} ms of processor time a file", flush=True
                )
    least = [min(costs[:5]), min(costs[-5:])]
    return {
        "seconds": report("all, s", time.perf_counter() - start),
        "first": report("a file of the first 5,000, ms of processor time", least[0]),
        "last": report("a file of the last 5,000", least[1]),
        "ratio": report("last / first", least[1] / least[0], "<= 1.2"),
    }


def _timed(action: Callable[[], object]) -> tuple[float, float, float]:
    """Wall time, processor time of this process, and of its children that have ended."""
    before = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    start = time.perf_counter()
    action()
    wall = time.perf_counter() - start
    after = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    used = [b.ru_utime + b.ru_stime - a.ru_utime - a.ru_stime for a, b in zip(before, after, strict=True)]
    return wall, used[0], used[1]


def _one_by_one(work: Callable[[list[Path]], None], groups: list[list[Path]]) -> None:
    for group in groups:
        work(group)


def _each(seconds: float, paths: list[Path]) -> float:
    return 1000 * seconds / len(paths)


def _imported(database: Database, paths: list[Path]) -> None:
    if len(paths) > 1:
        forget_skeletons()
    with ExitStack() as stack:
        files = [SourceFile(path.name, stack.enter_context(path.open("rb"))) for path in paths]
        done = import_files(database, files, ImportOptions(unit="cm"), Settings())
    if done.problems:
        raise done.problems[0][1]


def _uploaded(client: httpx.Client, paths: list[Path]) -> None:
    with ExitStack() as stack:
        files = [("file", (path.name, stack.enter_context(path.open("rb")))) for path in paths]
        answer = client.post("/documents", files=files, data={"unit": "cm"})
    if answer.status_code != 201:
        sys.exit(answer.text)


@contextmanager
def _store() -> Iterator[Database]:
    with tempfile.TemporaryDirectory() as place:
        database = Database(f"sqlite:///{place}/store.db")
        database.migrate()
        yield database
        database.close()


@contextmanager
def _served(derive: str = "no") -> Iterator[httpx.Client]:
    with tempfile.TemporaryDirectory() as place, serving(f"sqlite:///{place}/store.db", derive) as (_, port):
        yield httpx.Client(base_url=f"http://127.0.0.1:{port}/api/v1", timeout=600)
