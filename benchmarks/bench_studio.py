"""The studio in a browser: start, first card and frame, seeks, script a frame, memory, a library of 30,000 clips."""

from __future__ import annotations

import gc
import io
import itertools
import os
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from benchmarks.studio_library import LONG_RATE, LONG_SECONDS, fingered, library
from benchmarks.studio_pages import Visitor, browsing, seconds_asked, visiting
from benchmarks.timing import report
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.api.studio import STATIC
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from service.web.build import build

SMALL, LARGE = 300, 30_000
ROUNDS = 5
OPENED = 20
PLAYED = 8  # s
SCRUBBED = seconds_asked("MCML_BENCH_SCRUB", 60)
"""Seconds of scrubbing; 600 is what is promised."""
FILLED = 50  # s of scrubbing until all blocks have come
SCROLLED = 20  # s, from the top of the library to its bottom

Figures = dict[str, float]


def run() -> dict[str, object]:
    build()
    print(f"   {os.getloadavg()[0]:.1f} programs run on {os.cpu_count()} cores")
    with browsing() as browser, tempfile.TemporaryDirectory() as folder:
        small = _start(browser, library(SMALL))
        clips = _clips(Path(folder))
        return {
            f"library of {SMALL}": small,
            "clip": _clip(browser, *clips),
            f"library of {LARGE:,}": _scroll(browser, library(LARGE)),
        }


def _start(browser: Any, store: Path) -> Figures:
    """First card, first frame, size; medians of fresh visitors, who have nothing in their cache."""
    cards, frames, sizes, opened = [], [], [], []
    with visiting(browser, store) as first:
        uuid = first.get("/documents", limit=1)["items"][0]["id"]
        for _ in range(ROUNDS):
            with first.fresh() as visitor:
                visitor.open("/library")
                cards.append(visitor.drawn("first-cards"))
                sizes.append(sum(_gzipped(name) for name in visitor.scripts()))
                opened.append(visitor.clicked_open())
            with first.fresh() as visitor:
                visitor.open(f"/clips/{uuid}")
                frames.append(visitor.drawn("first-frame"))
        return {
            "start-up script": report("JavaScript before the first card, KB gzip", sizes[0] / 1e3, "<= 250"),
            "first card": report("first card drawn after navigation, s", statistics.median(cards), "<= 1.5"),
            "first frame": report("first frame of a clip after navigation, s", statistics.median(frames), "<= 1"),
            "click to frame": report("from the click on its card, s", statistics.median(opened), "<= 1"),
            **_opened(first),
        }


def _gzipped(name: str) -> int:
    packed = STATIC / "assets" / f"{name}.gz"
    return (packed if packed.is_file() else packed.with_suffix("")).stat().st_size


def _opened(visitor: Visitor) -> Figures:
    """Memory after the first clips, and after more of them were opened and left."""
    visitor.open("/library?sort=name")
    visitor.drawn("first-cards")
    heaps, resident = [], []
    for number in range(OPENED + 3):
        visitor.page.get_by_role("gridcell").nth(number % 8).click()
        visitor.page.wait_for_function(
            "count => performance.getEntriesByName('first-frame').length > count", arg=number
        )
        visitor.page.go_back()
        visitor.page.get_by_role("gridcell").first.wait_for()
        heaps.append(visitor.heap())
        resident.append(visitor.resident())
    what = f"{OPENED} clips opened and left"
    return {
        "heap of clips": report(f"{what}: JavaScript heap, MB more", heaps[-1] - heaps[2], "~ 0"),
        "resident of clips": report(f"{what}: resident in the renderer, MB more", resident[-1] - resident[2], "~ 0"),
    }


def _clips(folder: Path) -> tuple[Path, str, str]:
    """A store, and in it a clip of 20 s and one of 10 minutes, each of 61 joints at 120 Hz."""
    store = folder / "store.db"
    database = Database(f"sqlite:///{store}")
    database.migrate()
    found = []
    for name, seconds in (("short", 20), ("long", LONG_SECONDS)):
        source = SourceFile(f"{name}.bvh", io.BytesIO(fingered(seconds * LONG_RATE)))
        done = import_files(database, [source], ImportOptions(unit="cm"), Settings())
        found.append(done.documents[0].uuid)
        gc.collect()
    database.close()
    return store, found[0], found[1]


def _clip(browser: Any, store: Path, short: str, long: str) -> Figures:
    figures: Figures = {}
    with visiting(browser, store) as first:
        firsts, seeks = [], []
        for _ in range(ROUNDS):
            with first.fresh() as visitor:
                visitor.open(f"/clips/{long}")
                firsts.append(visitor.drawn("first-frame"))
                seeks.append(visitor.seek_to_end(LONG_SECONDS * LONG_RATE))
        figures["long: first frame"] = report("10 minutes at 120 Hz: first frame, s", statistics.median(firsts), "<= 1")
        figures["long: seek"] = report("seek to its end, exact frame there, s", statistics.median(seeks), "<= 1")
        with first.fresh() as visitor:
            visitor.open(f"/clips/{short}")
            visitor.drawn("first-frame")
            figures |= _script(visitor, "a body of 61 joints", "")
            visitor.page.get_by_role("button", name="ghosts", exact=True).click()
            figures |= _script(visitor, "it and four ghosts", "<= 4 for 4 bodies")
        with first.fresh() as visitor:
            visitor.open(f"/clips/{long}")
            visitor.drawn("first-frame")
            figures |= _scrubbed(visitor)
    return figures


def _script(visitor: Visitor, what: str, wanted: str) -> Figures:
    """ms of script in each frame while the clip plays, all callbacks together: clock, positions, scene, timeline."""
    visitor.page.locator(".stage").focus()
    visitor.page.keyboard.press("Space")
    time.sleep(1)
    with visitor.watched() as watched:
        time.sleep(PLAYED)
    visitor.page.keyboard.press("Space")
    scripts, middle = watched.scripts, statistics.median(watched.scripts)
    processor = watched.script_processor / len(scripts)
    return {
        f"{what}: script": report(f"{what}: script a frame, median, ms", middle, wanted),
        f"{what}: script, processor": report("   mean, ms of processor time", processor, wanted),
        f"{what}: frames": report("   frames a second, drawn without a graphics card", len(scripts) / PLAYED),
        f"{what}: longest task": report("   longest task, ms of processor time", watched.processor, "<= 50"),
    }


def _scrubbed(visitor: Visitor) -> Figures:
    """Memory while the time is dragged over a clip of 10 minutes, once the blocks of all of it are kept (66 MB)."""
    box = visitor.page.locator(".timeline-canvas").bounding_box()
    y, left, wide = box["y"] + 8, box["x"] + 4, box["width"] - 8
    visitor.page.mouse.move(left, y)
    visitor.page.mouse.down()
    _drag(visitor, _there_and_back(left, wide, y), FILLED)
    heaps, resident = [visitor.heap()], [visitor.resident()]
    end = time.perf_counter() + SCRUBBED
    while time.perf_counter() < end:
        _drag(visitor, _there_and_back(left, wide, y), min(15, SCRUBBED / 4))
        heaps.append(visitor.heap())
        resident.append(visitor.resident())
    # Apart: what is recorded takes memory too.
    with visitor.watched() as watched:
        _drag(visitor, _there_and_back(left, wide, y), PLAYED)
    visitor.page.mouse.up()
    minutes = f"{SCRUBBED / 60:g} min of scrubbing"
    return {
        "scrub: heap": report(f"{minutes}: JavaScript heap at first, MB", heaps[0]),
        "scrub: heap more": report("   more at the end, MB", heaps[-1] - heaps[0], "~ 0"),
        "scrub: resident": report("   resident in the renderer at first, MB", resident[0]),
        "scrub: resident more": report("   more at the end, MB", resident[-1] - resident[0], "~ 0"),
        "scrub: longest task": report("   longest task, ms of processor time", watched.processor, "<= 50"),
    }


def _there_and_back(left: float, wide: float, y: float) -> Callable[[], Iterator[tuple[float, float]]]:
    steps = [*range(200), *range(200, 0, -1)]
    return lambda: ((left + wide * step / 200, y) for step in itertools.cycle(steps))


def _drag(visitor: Visitor, path: Callable[[], Iterator[tuple[float, float]]], seconds: float) -> None:
    end = time.perf_counter() + seconds
    for x, y in path():
        visitor.page.mouse.move(x, y)
        if time.perf_counter() > end:
            return


def _scroll(browser: Any, store: Path) -> Figures:
    """The library from its top to its bottom, in even steps, one a frame."""
    with visiting(browser, store) as visitor:
        visitor.open("/library")
        card = visitor.drawn("first-cards")
        time.sleep(2)  # facets come after the cards
        with visitor.watched() as watched:
            frames = visitor.page.evaluate(SCROLL, SCROLLED * 1000)
            time.sleep(2)
        name = visitor.page.get_by_role("gridcell").last.inner_text().split("\n")[0]
        assert name, "the last clip is shown"
        tasks = watched.long_tasks
        return {
            "first card": report(f"{LARGE:,} clips: first card drawn, s", card, "<= 1.5"),
            "longest task": report("top to bottom: longest task, ms of processor time", watched.processor, "<= 50"),
            "longest task, clock": report("   by the clock, other work included, ms", max(tasks, default=0.0)),
            "long tasks, clock": report("   tasks above 50 ms by the clock", len(tasks)),
            "frames": report("   frames a second", frames / SCROLLED),
        }


SCROLL = """milliseconds => new Promise(done => {
  const list = document.querySelector(".virtual");
  const whole = list.scrollHeight - list.clientHeight;
  let frames = 0;
  let began = -1;
  const step = now => {
    if (began < 0) began = now;
    const share = Math.min(1, (now - began) / milliseconds);
    list.scrollTop = share * whole;
    frames++;
    if (share < 1) requestAnimationFrame(step); else done(frames);
  };
  requestAnimationFrame(step);
})"""
