"""Lists of 100,000 documents over HTTP: pages wherever they are, narrowed, searched, in any order; facets; the feed."""

from __future__ import annotations

import shutil
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

import httpx

from benchmarks.library import serving
from benchmarks.many_documents import many_documents
from benchmarks.timing import report

DOCUMENTS = 100_000
ROUNDS = 9
STUDIO = {"limit": 60, "with": "thumbnail,labels,passport"}

PAGES: dict[str, dict[str, Any]] = {
    "first page, 100 documents": {},
    "newest first": {"sort": "newest"},
    "first page as the studio asks": {"sort": "newest", **STUDIO},
    "the middle, as the studio asks": {"sort": "newest", "offset": 50_000, **STUDIO},
    "the end": {"offset": DOCUMENTS - 100},
    "of a project": {"project": "project-3", "offset": 4000},
    "with a motion name": {"motion_name": "variant-7"},
    "with a property in a range": {"property": "age:20..{k}", "offset": 9000},
    "with a length and a rate": {"length": "0.{k}..1", "rate": "60"},
    "with a word that few have": {"q": "walk_05{k}1"},
    "with words that many have": {"q": "on day {k}", "offset": 500},
    "with three words": {"q": "day {k} wal"},
    "by frames": {"sort": "frames", "offset": 50_000},
    "by duration, longest first": {"sort": "-duration", "offset": 50_000},
    "by format, of a search": {"sort": "format", "q": "dance {k}", "offset": 1000},
    "by time of the last change": {"sort": "-modified", "offset": 50_000},
    "by project, backwards": {"sort": "-project", "offset": 50_000},
}
FACETS: dict[str, dict[str, Any]] = {
    "of all": {},
    "of a project": {"project": "project-3"},
    "of a search": {"q": "dance {k}"},
    "of three words": {"q": "day {k} wal"},
    "of a property in a range": {"property": "age:{k}..69"},
    "of what has a motion name": {"motion_name": "walk"},
}


def run() -> dict[str, float]:
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        # Edits are made: the store that is kept stays as it is.
        store = shutil.copy(many_documents(DOCUMENTS), Path(folder) / "store.db")
        with serving(f"sqlite:///{store}") as (_, port):
            base = f"http://127.0.0.1:{port}/api/v1"
            with httpx.Client(base_url=base, timeout=120) as client:
                _measure(client, figures)
    return figures


def _measure(client: httpx.Client, figures: dict[str, float]) -> None:
    figures["first"] = report("the first page of a process, ms", _asked(client, "/documents", {}))
    figures["first facets"] = report("the first facets of it, ms", _asked(client, "/facets", {}))
    figures["second facets"] = report("the second ones, ms", _asked(client, "/facets", {}))
    for name, given in PAGES.items():
        _median(client, figures, f"page, {name}", "/documents", given)
    deep = {"sort": "-frames", "cursor": _deep(client)}
    _median(client, figures, "page, behind a cursor far down", "/documents", deep)
    for name, given in FACETS.items():
        _median(client, figures, f"facets, {name}", "/facets", given)
    _after_edits(client, figures)
    _feed(client, figures)


def _deep(client: httpx.Client) -> str:
    page = client.get("/documents", params={"sort": "-frames", "offset": DOCUMENTS - 5000, "limit": 10})
    return str(page.json()["next_cursor"])


def _after_edits(client: httpx.Client, figures: dict[str, float]) -> None:
    """Each time a document has another name since."""
    found = client.get("/documents", params={"limit": ROUNDS * 3, "offset": 500}).json()["items"]
    for name, path, given in (
        ("page by frames", "/documents", {"sort": "frames"}),
        ("facets", "/facets", {}),
        ("page of a search", "/documents", {"q": "walk 5"}),
    ):
        times = []
        for number in range(ROUNDS):
            item = found.pop()
            change = {"name": f"renamed {number}"}
            answer = client.patch(f"/documents/{item['id']}", json=change, headers={"if-match": "*"})
            answer.raise_for_status()
            times.append(_asked(client, path, given))
        figures[f"after an edit: {name}"] = report(f"after an edit: {name}, ms", statistics.median(times), "<= 30")


def _feed(client: httpx.Client, figures: dict[str, float]) -> None:
    """What somebody is told who knows all but the last change."""
    newest = client.get("/events", params={"seconds": 0}).text.partition("id: ")[2].partition("\n")[0]
    number, _, moment = newest.partition("@")
    known: dict[str, str | int] = {"since": f"{int(number) - 1}@{moment}", "seconds": 0}
    told = client.get("/events", params=known).text.count("event: document")
    _median(client, figures, f"feed of changes, {told} since", "/events", known)


def _median(client: httpx.Client, figures: dict[str, float], name: str, path: str, given: dict[str, Any]) -> None:
    # Each with a number not asked before: what fulfils conditions is kept.
    times = [_asked(client, path, _filled(given, k)) for k in range(20, 21 + ROUNDS)]
    again = statistics.median(times[1:])
    figures[name] = report(f"{name}, ms", again, "<= 30")


def _filled(given: dict[str, Any], k: int) -> dict[str, Any]:
    return {name: value.replace("{k}", str(k)) if isinstance(value, str) else value for name, value in given.items()}


def _asked(client: httpx.Client, path: str, given: dict[str, Any]) -> float:
    start = time.perf_counter()
    answer = client.get(path, params=given)
    took = (time.perf_counter() - start) * 1000
    if answer.status_code != 200:
        print(f"      {answer.status_code}: {answer.json().get('title')} {given}")
    return took
