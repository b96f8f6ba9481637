"""Windows of the analyses in a browser: the map of faces, of 100,000 generated frames and of real takes."""

from __future__ import annotations

import os
import statistics
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.studio_pages import Visitor, browsing, visiting
from benchmarks.timing import report
from schemas.analyses.expression import ExpressionParameters
from service.actions.analysing.save_results import add_parts
from service.analysis.expression_space.analyses import EXPRESSION
from service.analysis.interface import Part, Parts, silent
from service.storage.database import Database
from service.web.build import build
from tests.analysis.expression.test_real_takes import faces

FRAMES = 100_000
MARKERS = 25
TAKES = 40
PANNED = 240
"""Moves of the pointer over the map."""

Figures = dict[str, float]


def run() -> dict[str, object]:
    build()
    print(f"   {os.getloadavg()[0]:.1f} programs run on {os.cpu_count()} cores")
    found: dict[str, object] = {}
    shared = Path(os.environ.get("MCML_SHARED", Path(__file__).parents[2] / "shared" / "data"))
    with browsing() as browser:
        found[f"map of {FRAMES:,} points"] = _panned(browser, generated(FRAMES), FRAMES)
        if (shared / "trc_facial").is_dir():
            real = EXPRESSION.run(faces(shared, 1), ExpressionParameters(), silent)
            count = len(real["map"].arrays["take"])
            found[f"map of real takes, {count:,} points"] = _panned(browser, real, count)
    return found


def _panned(browser: Any, parts: Parts, count: int) -> Figures:
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "store.db"
        database = Database(f"sqlite:///{store}")
        database.migrate()
        with database.write("bench") as tx:
            key, uuid = tx.results.add(tx.projects.get_or_add("faces"), "expression", "faces", "bench", [], {}, {})
            add_parts(tx, key, parts, {})
        database.close()
        with visiting(browser, store) as visitor:
            levels = [row[2] for row in parts["levels"].data["rows"]]
            level = max(number for number, candidates in enumerate(levels) if candidates <= 3000)
            visitor.open(f"/faces/{uuid}?level={level}")
            visitor.page.wait_for_function("() => performance.getEntriesByName('map-drawn').length > 0")
            opened = float(visitor.page.evaluate("() => performance.getEntriesByName('map-drawn')[0].startTime"))
            scripts = pan(visitor)
    title = f"{count:,} points, {levels[level]:,} candidates"
    return {
        "opened": report(f"map of {title}: drawn after navigation, s", opened / 1e3),
        "script, median": report("panned: script a frame, ms, median", statistics.median(scripts), "<= 8"),
        "script, 95 %": report("the same, 95th percentile", scripts[int(0.95 * len(scripts))], "<= 8"),
    }


def pan(visitor: Visitor) -> list[float]:
    """ms of script of each frame while the map is dragged about; sorted."""
    box = visitor.page.locator(".faces-map").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    with visitor.watched() as watched:
        visitor.page.mouse.move(x, y)
        visitor.page.mouse.down()
        for step in range(PANNED):
            angle = step / 20
            visitor.page.mouse.move(x + 120 * np.cos(angle), y + 80 * np.sin(angle))
        visitor.page.mouse.up()
    return watched.scripts


def generated(count: int) -> Parts:
    """The parts of a space of so many frames that nobody computed: places and links as such a space has them."""
    rng = np.random.default_rng(1)
    take = (np.arange(count) * TAKES // count).astype(np.int32)
    along = np.linspace(0, 1, count // TAKES + 1)[np.arange(count) % (count // TAKES + 1)]
    angle = 2 * np.pi * take / TAKES
    far = 800 * np.sin(np.pi * along) + rng.normal(0, 6, count)
    plane = np.stack([np.cos(angle) * far, np.sin(angle) * far], axis=1) + rng.normal(0, 8, (count, 2))
    sizes = [11 << level for level in range(9)]
    candidates = [np.sort(rng.choice(count, size, replace=False)) for size in sizes] + [np.arange(count)]
    first = np.concatenate([[0], np.cumsum([len(own) for own in candidates])]).astype(np.int64)
    near = [_nearest(plane[own]) for own in candidates[:-1]]
    starts = np.concatenate([[0], np.cumsum([len(pairs) for pairs in near]), [sum(map(len, near))]]).astype(np.int64)
    pairs = np.concatenate(near)
    face = rng.normal(0, 40, (MARKERS, 3))
    documents = [f"take {number}" for number in range(TAKES)]
    summary = {
        "frames": count,
        "takes": TAKES,
        "markers": MARKERS,
        "markers_dropped": [],
        "levels": len(candidates),
        "tau_mm": 200.0,
        "bridges": 0,
        "r": 0.95,
        "stress": 0.25,
        "speed_mm_s": 300.0,
        "warnings": [],
    }
    columns = [{"name": name, "unit": ""} for name in ("level", "wanted", "candidates")]
    rows = [[number, len(own), len(own)] for number, own in enumerate(candidates)]
    values = {"documents": documents, "names": documents, "up": "Y", "neutral": 0}
    places = (face + rng.normal(0, 3, (count, 1, 3))).astype(np.float32)
    return {
        "space": Part("model", {"summary": summary, "values": values}, {"positions": places}),
        "map": Part("points", {}, {"coordinates": plane, "take": take, "frame": np.arange(count, dtype=np.int32)}),
        "levels": Part(
            "table", {"columns": columns, "rows": rows}, {"candidates": np.concatenate(candidates), "first": first}
        ),
        "links": Part(
            "graph",
            {},
            {
                "first": starts,
                "a": pairs[:, 0].astype(np.int32),
                "b": pairs[:, 1].astype(np.int32),
                "length": np.full(len(pairs), 120, np.float32),
                "bridge": np.zeros(len(pairs), np.uint8),
            },
        ),
        "tau": Part("curve", {"chosen": 200.0, "rows": []}),
    }


def _nearest(places: np.ndarray) -> np.ndarray:
    """(n, 2) pairs of places that are near each other, two of each at most."""
    from scipy.spatial import cKDTree

    _, found = cKDTree(places).query(places, k=3)
    pairs = np.concatenate([np.stack([found[:, 0], found[:, place]], axis=1) for place in (1, 2)])
    return np.unique(np.sort(pairs, axis=1), axis=0)
