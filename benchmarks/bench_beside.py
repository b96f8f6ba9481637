"""A library of thousands of short clips beside BaseX: 19 questions, each whole answer read, answers compared.

`MCML_LIBRARIES`: its first folder of BVH files. The documents are exported as MCML for BaseX, once, beside the store.
"""

from __future__ import annotations

import math
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import httpx

from benchmarks import basex_client
from benchmarks.bench_library import store_of
from benchmarks.library import serving
from benchmarks.timing import report
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter

ROUNDS = 5
LEG, OTHER = "frame_bone[@name='left_up_leg']", "frame_bone[@name='right_up_leg']"
QUESTIONS = (
    "count(//frame)",
    "count(//frame_bone)",
    "count(//header)",
    "count(//bone)",
    f"count(//{LEG}[@Rx>60])",
    f"max(//{LEG}/@Rx)",
    f"min(//{LEG}/@Rx)",
    f"avg(//{LEG}/@Rx)",
    f"sum(//{LEG}/@Rx)",
    f"//frame[number({LEG}/@Rx) > number({OTHER}/@Rx)]/@id/string()",
    "//frame[100]/@id/string()",
    "//frame[frame_bone[@name='Root']/@Ty > 120]/@id/string()",
    "count(//frame[frame_bone/@Rx > 170])",
    "//filename[contains(., 'walk_1')]/string()",
    "distinct-values(//motion_name)",
    "count(//frame[position() mod 10 = 1][frame_bone[@name='left_low_leg']/@Rx > 30])",
    "count(//frame[@id='7'])",
    "for $m in /mcml return count($m//frame)",
    "string-join(sort(distinct-values(//bone/name)), ',')",
)
FIRST = 100


def run() -> dict[str, object]:
    folder = next((Path(part) for part in os.environ.get("MCML_LIBRARIES", "").split(":") if part), None)
    if folder is None:
        sys.exit("MCML_LIBRARIES names no folder of BVH files")
    store = store_of(folder)
    texts = _exported(store)
    found: dict[str, object] = {}
    with (
        tempfile.TemporaryDirectory() as home,
        basex_client.serving(Path(home)) as basex,
        serving(f"sqlite:///{store}") as (_, port),
        httpx.Client(base_url=f"http://127.0.0.1:{port}/api/v1", timeout=120) as ours,
    ):
        start = time.perf_counter()
        basex.execute("SET CHOP true")
        basex.execute(f"CREATE DB library {texts}")
        report("BaseX reads the library, s", time.perf_counter() - start)
        basex.query("library", "1")
        for question in QUESTIONS:
            theirs, other = _timed(lambda asked=question: _basex(basex, asked))
            own, answer = _timed(lambda asked=question: _ours(ours, asked))
            equal = _same(answer, other)
            if not equal and len(answer) == len(other) == FIRST:
                # BaseX keeps documents in an order of its own: of a page of them, the whole is counted instead.
                equal = _same(_ours(ours, f"count({question})"), _basex(basex, f"count({question})"))
            same = "equal" if equal else f"DIFFERENT: {answer[:3]} {other[:3]}"
            found[question] = [own, theirs]
            print(
                f"   {question[:66]:66} {own:8.1f} ms  BaseX {theirs:8.1f} ms  {theirs / own:7.1f}x  {same}", flush=True
            )
    return found


def _timed(ask: Any) -> tuple[float, list[str]]:
    """(median ms once warm, the first answers)."""
    answer = ask()
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        answer = ask()
        times.append((time.perf_counter() - start) * 1000)
    return statistics.median(times), answer


def _ours(client: httpx.Client, question: str) -> list[str]:
    answer = client.get("/xpath", params={"q": question, "limit": FIRST})
    if answer.status_code != 200:
        return [answer.json()["title"]]
    found = answer.json()
    return [str(found["value"])] if found.get("value") is not None else [str(each["value"]) for each in found["items"]]


def _basex(client: basex_client.BaseXClient, question: str) -> list[str]:
    # As many items as our page has, one a line.
    asked = f"string-join(subsequence(({question}), 1, {FIRST}) ! string(.), '&#10;')"
    found = client.query("library", asked).decode()
    return found.split("\n") if found else []


def _same(one: list[str], other: list[str]) -> bool:
    return len(one) == len(other) and all(map(_equal, one, other))


def _equal(one: str, other: str) -> bool:
    try:
        return math.isclose(float(one), float(other), rel_tol=1e-9)
    except ValueError:
        return one == other


def _exported(store: Path) -> Path:
    """A folder of MCML files whose names have the order of the documents."""
    texts = store.with_name("texts")
    if texts.is_dir():
        return texts
    unfinished = store.with_name("texts-unfinished")
    unfinished.mkdir(exist_ok=True)
    database = Database(f"sqlite:///{store}")
    with database.read() as tx:
        for number, stored in enumerate(tx.documents.page(DocumentFilter(), after=None, limit=1_000_000)):
            content = export_document(tx, stored, ExportOptions("mcml")).content
            (unfinished / f"{number:06}.xml").write_bytes(b"".join(content))
    database.close()
    unfinished.rename(texts)
    return texts
