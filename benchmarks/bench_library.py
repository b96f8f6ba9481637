"""Libraries of thousands of clips, over HTTP: every class of question, warm and by a fresh process; import and lists.

`MCML_LIBRARIES`: folders of BVH files, separated by colons; their stores are made once, beside them.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from pathlib import Path
from typing import Any

import httpx

from benchmarks.library import serving
from benchmarks.library_questions import CLASSES
from benchmarks.start import measure_start
from benchmarks.timing import report
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

AT_ONCE = 512
ROUNDS = 7
SMALL = 10_000


def run() -> dict[str, object]:
    folders = [Path(part) for part in os.environ.get("MCML_LIBRARIES", "").split(":") if part]
    if not folders:
        sys.exit("MCML_LIBRARIES names no folder of BVH files")
    return {f"{folder.name}": _library(folder) for folder in folders}


def _library(folder: Path) -> dict[str, Any]:
    store = store_of(folder)
    found: dict[str, Any] = {"start": measure_start(store)}
    with serving(f"sqlite:///{store}") as (_, port), httpx.Client(base_url=f"http://127.0.0.1:{port}/api/v1") as client:
        client.timeout = httpx.Timeout(120)
        documents = client.get("/documents", params={"limit": 1}).json().get("total") or 0
        empty = statistics.median(_asked(client, f"1{k}") for k in range(15))
        for one in CLASSES:
            print(f"   -- {one.name}: {one.wanted[documents > SMALL]} ms wanted")
            for question in one.questions:
                first = _asked(client, question.replace("{k}", "3")) - empty
                again = [_asked(client, question.replace("{k}", str(20 + k))) - empty for k in range(ROUNDS)]
                warm = statistics.median(again)
                found[question] = report(f"{question[:58]} (first {first:.0f})", warm)
    return found


def _asked(client: httpx.Client, question: str) -> float:
    start = time.perf_counter()
    answer = client.get("/xpath", params={"q": question, "limit": 100})
    took = (time.perf_counter() - start) * 1000
    if answer.status_code != 200:
        print(f"      {answer.status_code}: {answer.json().get('title')} {question}")
    return took


def store_of(folder: Path) -> Path:
    """The store of a folder's files, made where it is not there."""
    store = folder.with_name(f"{folder.name}-store") / "store.db"
    if store.is_file():
        return store
    store.parent.mkdir(exist_ok=True)
    unfinished = store.with_name("unfinished.db")
    unfinished.unlink(missing_ok=True)
    database = Database(f"sqlite:///{unfinished}")
    database.migrate()
    paths = sorted(folder.glob("*.bvh"))
    start = time.perf_counter()
    for at in range(0, len(paths), AT_ONCE):
        files = [SourceFile(path.name, path.open("rb")) for path in paths[at : at + AT_ONCE]]
        done = import_files(database, files, ImportOptions(unit="cm"), Settings())
        for file in files:
            file.stream.close()
        if done.problems:
            raise done.problems[0][1]
        if at // AT_ONCE % 10 == 0:
            print(f"      {at + len(files):,} clips, {time.perf_counter() - start:.0f} s", flush=True)
    database.close()
    unfinished.rename(store)
    report(f"import of {len(paths):,} files, s", time.perf_counter() - start)
    return store
