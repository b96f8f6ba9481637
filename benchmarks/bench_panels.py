"""Windows of the analyses in a browser: sliders of 185 reaches; the map of faces, 100,000 generated and real ones."""

from __future__ import annotations

import os
import statistics
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.studio_pages import Visitor, browsing, visiting
from benchmarks.timing import report
from mcml_schemas.analyses.expression import ExpressionParameters
from mcml_schemas.analyses.reach import ReachParameters
from mcml_service.actions.analysing.save_results import add_parts
from mcml_service.actions.importing.load_demo import REACHES, add_clips
from mcml_service.analysis.expression_space.analyses import EXPRESSION
from mcml_service.analysis.interface import Part, Parts, silent
from mcml_service.analysis.reach_blending.analyses import REACH
from mcml_service.demo.reach_clips import reach_clips
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from service.web.build import build
from tests.analysis.expression.test_real_takes import faces
from tests.analysis.reach.reach_motions import motion_of

FRAMES = 100_000
MARKERS = 25
TAKES = 40
SLID = 200
"""Moves of the slider."""
PANNED = 240
"""Moves of the pointer over the map."""

Figures = dict[str, float]


def run() -> dict[str, object]:
    build()
    print(f"   {os.getloadavg()[0]:.1f} programs run on {os.cpu_count()} cores")
    found: dict[str, object] = {}
    shared = Path(os.environ.get("MCML_SHARED", Path(__file__).parents[2] / "shared" / "data"))
    with browsing() as browser:
        found["sliders of 185 reaches"] = _slid(browser)
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


def _slid(browser: Any) -> Figures:
    """From the move of a slider until the frame in which the new motion was drawn, script of that frame included."""
    figures: Figures = {}
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "store.db"
        database = Database(f"sqlite:///{store}")
        database.migrate()
        made = reach_clips()
        add_clips(database, Settings(), REACHES, [one.clip for one in made], (), "")
        parameters = ReachParameters()
        with database.read() as tx:
            ids = {one.name: one.uuid for one in tx.documents.page(DocumentFilter(), after=None, limit=len(made))}
        motions = [replace(motion_of(one), document=ids[one.name]) for one in made]
        parts = REACH.run(motions, parameters, silent)
        with database.write("bench") as tx:
            given = parameters.model_dump(mode="json")
            key, uuid = tx.results.add(tx.projects.get_or_add(REACHES), "reach", "reaches", "bench", [], given, {})
            add_parts(tx, key, parts, {})
        database.close()
        with visiting(browser, store) as visitor:
            for view, playing in (("alone", False), ("alone", True), ("ghost", True)):
                visitor.open(f"/reach/{uuid}?near={view}")
                visitor.page.wait_for_function("() => performance.getEntriesByName('new-motion').length > 0")
                visitor.page.get_by_role("button", name="Pause").wait_for()
                if not playing:
                    visitor.page.get_by_role("button", name="Pause").click()
                drawn, answered = visitor.page.evaluate(SLIDE, SLID)
                what = f"slider of {len(made)} examples, {view}, {'playing' if playing else 'still'}"
                figures[f"{what}: median"] = report(f"{what}: new motion drawn, ms, median", statistics.median(drawn))
                figures[f"{what}: 95 %"] = report("   95th percentile", sorted(drawn)[int(0.95 * len(drawn))], "<= 50")
                figures[f"{what}: answered"] = report(
                    "   the server's answer in the page, 95th percentile", sorted(answered)[int(0.95 * len(answered))]
                )
    return figures


SLIDE = """async moves => {
  performance.clearMeasures("new-motion");
  performance.clearResourceTimings();
  performance.setResourceTimingBufferSize(10000);
  const slider = document.querySelectorAll(".slider-track")[1];
  slider.focus();
  for (let move = 0; move < moves; move++) {
    const key = move % 60 < 30 ? "ArrowLeft" : "ArrowRight";
    slider.dispatchEvent(new KeyboardEvent("keydown", { key, code: key, bubbles: true, cancelable: true }));
    await new Promise(done => setTimeout(done, 60));
  }
  await new Promise(done => setTimeout(done, 1000));
  return [
    performance.getEntriesByName("new-motion").map(one => one.duration),
    performance.getEntriesByType("resource").filter(one => one.name.includes("synthesize")).map(one => one.duration),
  ];
}"""


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

    _, nearest = cKDTree(places).query(places, k=3)
    found = np.asarray(nearest)
    pairs = np.concatenate([np.stack([found[:, 0], found[:, place]], axis=1) for place in (1, 2)])
    return np.unique(np.sort(pairs, axis=1), axis=0)
