"""Bodies of a library: what it costs to derive and to keep them, questions about them beside questions about channels,
poses and motions that are most alike.

`MCML_LIBRARIES`: folders of BVH files, separated by colons; their stores are made once, beside them, and copied.
"""

from __future__ import annotations

import os
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import httpx
from sqlalchemy import text

from benchmarks.bench_library import store_of
from benchmarks.library import serving
from benchmarks.timing import report
from mcml_service.clips.derive import derive_missing
from mcml_service.storage.database import Database

DERIVED, ROUNDS = 3, 9
"""How often bodies are derived, and a question is asked; the least and the median count."""
SERVERS = 3
"""Processes that are each asked one question, after the columns beside the store were made."""

PAIRS = {
    "knee": ("mo:angle('left-knee-flexion') > {k}", "frame_bone[@name='left_low_leg']/@Rx > {k}"),
    "height of a hand": ("mo:height('left_hand') > 1.{k}", "frame_bone[@name='Root']/@Ty > 90.{k}"),
    "speed of a hand": ("mo:speed('right_hand') > 1.{k}", "frame_bone[@name='right_low_arm']/@Rx > {k}"),
}
"""A quantity, and a channel that takes as many values."""
ALIKE = {
    "nearest pose": "mo:top(20, //frame, -mo:pose-distance('{document}', {k}))",
    "nearest motion": "mo:top(20, //frame, -mo:motion-distance('{document}', {k}, {end}))",
}
FIRST, LAST = 20, 60
"""Of the document that is searched for; each question has another frame."""


def run() -> dict[str, object]:
    folders = [Path(part) for part in os.environ.get("MCML_LIBRARIES", "").split(":") if part]
    if not folders:
        sys.exit("MCML_LIBRARIES names no folder of BVH files")
    return {folder.name: _library(folder) for folder in folders}


def _library(folder: Path) -> dict[str, Any]:
    original = store_of(folder)
    with tempfile.TemporaryDirectory(dir=folder.parent) as place:
        store = Path(place) / "store.db"
        shutil.copy(original, store)
        found = _derived(store)
        found |= _asked(f"sqlite:///{store}")
    return found


def _derived(store: Path) -> dict[str, float]:
    database = Database(f"sqlite:///{store}")
    database.migrate()
    costs = []
    for _ in range(DERIVED):
        with database.write() as tx:
            tx.connection.execute(text("DELETE FROM body"))
        before, began, start = _room(database), time.process_time(), time.perf_counter()
        clips = derive_missing(database, lambda done, of: None)
        costs.append((time.process_time() - began, time.perf_counter() - start))
    with database.read() as tx:
        frames = sum(listed.frames for listed in tx.columns.documents())
    grown = _room(database) - before
    uploads = database.size()["uploads"]
    database.close()
    processor, wall = min(costs)
    print(f"   -- {clips:,} clips, {frames:,} frames, derived {DERIVED} times in {wall:.1f} s and more")
    return {
        "derive": report("derive 1,000 frames, ms of processor time", processor * 1e6 / frames, "<= 8"),
        "a frame": report("bytes of a frame", grown / frames),
        "growth": report("growth of the store without uploads, %", 100 * grown / (before - uploads)),
        "growth of all": report("growth of the store with uploads, %", 100 * grown / before),
    }


def _room(database: Database) -> int:
    """Bytes of pages that hold something."""
    with database.read() as tx:
        pages, free, size = (
            int(tx.connection.exec_driver_sql(f"PRAGMA {name}").scalar_one())
            for name in ("page_count", "freelist_count", "page_size")
        )
    return (pages - free) * size


def _asked(url: str) -> dict[str, float]:
    found: dict[str, float] = {}
    with serving(url) as (_, port), _client(port) as client:
        items = client.get("/documents", params={"limit": 100}).json()["items"]
        document = next(item["id"] for item in items if item["frames"] > LAST + 2 * ROUNDS)
        empty = _median(client, lambda k: f"{k}")
        for name, (quantity, channel) in PAIRS.items():
            times = []
            for condition in (quantity, channel):
                question = f"count(//frame[{condition}])"
                _ms(client, question.format(k=FIRST))
                times.append(_median(client, partial(_filled, question)))
            found[name] = report(f"{name}: ms warm", times[0] - empty)
            found[f"{name}, channel"] = report(f"{name}: the same of a channel", times[1] - empty)
            # What is left of a channel's time may be less than the noise of the way.
            found[f"{name}, ratio"] = report(f"{name}: ratio of the whole answers", times[0] / times[1])
        for name, question in ALIKE.items():
            ask = _about(question, document)
            first = _ms(client, ask(FIRST)) - empty
            found[name] = report(f"{name} (first {first:.0f}): ms warm", _median(client, ask) - empty)
    for name, question in ALIKE.items():
        times = []
        for place in range(SERVERS):
            with serving(url) as (_, port), _client(port) as client:
                # Whoever asks is there: what is measured is the question alone.
                _ms(client, "1")
                times.append(_ms(client, _about(question, document)(FIRST + ROUNDS + 1 + place)) - empty)
        found[f"{name}, new"] = report(f"{name}: ms in a new process", statistics.median(times))
    return found


def _about(question: str, document: str) -> Callable[[int], str]:
    return lambda k: question.format(document=document, k=k, end=k + LAST - FIRST)


def _client(port: int) -> httpx.Client:
    return httpx.Client(base_url=f"http://127.0.0.1:{port}/api/v1", timeout=120)


def _filled(question: str, k: float) -> str:
    return question.format(k=k)


def _median(client: httpx.Client, question: Callable[[int], str]) -> float:
    return statistics.median(_ms(client, question(FIRST + 1 + place)) for place in range(ROUNDS))


def _ms(client: httpx.Client, question: str) -> float:
    start = time.perf_counter()
    answer = client.get("/xpath", params={"q": question, "limit": 100})
    took = (time.perf_counter() - start) * 1000
    if answer.status_code != 200:
        sys.exit(f"{answer.status_code}: {answer.text} {question}")
    return took
