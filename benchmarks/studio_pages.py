"""A browser on a server process, and what a page says of its speed, script and memory."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx

from benchmarks.library import serving

FLAGS = ["--gaia-url=http://127.0.0.1:9", "--component-updater=url-source=http://127.0.0.1:9/"]
"""Nothing leaves: Chromium's own questions to its maker."""
LOOK = {"viewport": {"width": 1280, "height": 800}, "locale": "en"}
WATCH = """
window.longTasks = [];
new PerformanceObserver(list => { for (const one of list.getEntries()) longTasks.push(one.duration); })
  .observe({ type: "longtask", buffered: true });
// Script of each drawn frame: all that is run in callbacks of one requestAnimationFrame.
window.frameScripts = [];
window.drawn = {};
const wait = window.requestAnimationFrame.bind(window);
let frame = -1;
window.requestAnimationFrame = callback => wait(now => {
  const started = performance.now();
  try { callback(now); } finally {
    const spent = performance.now() - started;
    if (now === frame) frameScripts[frameScripts.length - 1] += spent;
    else { frameScripts.push(spent); frame = now; }
  }
});
// A mark is set when something is there to be drawn; it is on the screen by the frame after the next.
new PerformanceObserver(list => {
  for (const { name } of list.getEntries()) {
    if (!(name in drawn)) { drawn[name] = 0; wait(() => wait(now => { drawn[name] = now; })); }
  }
}).observe({ type: "mark", buffered: true });
addEventListener("keydown", event => { window.pressed = event.timeStamp; }, true);
addEventListener("click", event => { window.clicked = event.timeStamp; }, true);
"""


def chromium() -> str | None:
    """Debian's, or another that is installed."""
    names = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    return next((found for found in map(shutil.which, names) if found), None)


@contextmanager
def browsing() -> Iterator[Any]:
    """A browser of Playwright. RuntimeError where none is installed."""
    from playwright.sync_api import sync_playwright

    path = chromium()
    if path is None:
        raise RuntimeError("no Chromium on this machine: apt-get install chromium")
    with sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield launched
        launched.close()


@contextmanager
def visiting(browser: Any, store: Path) -> Iterator[Visitor]:
    """A visitor of a server process on the store."""
    with serving(f"sqlite:///{store}") as (_, port):
        first = Visitor(browser, f"http://127.0.0.1:{port}")
        yield first
        first.close()


class Visitor:
    """A page with an empty cache, and what is measured in it."""

    def __init__(self, browser: Any, url: str) -> None:
        self.browser, self.url = browser, url
        self.context = browser.new_context(**LOOK)
        self.context.add_init_script(WATCH)
        self.page = self.context.new_page()
        self.page.set_default_timeout(60_000)
        self._devtools = self.context.new_cdp_session(self.page)
        self._devtools.send("Performance.enable")

    @contextmanager
    def fresh(self) -> Iterator[Visitor]:
        """Another visitor of the same server."""
        other = Visitor(self.browser, self.url)
        yield other
        other.close()

    def close(self) -> None:
        self.context.close()

    def get(self, path: str, **params: Any) -> Any:
        return httpx.get(f"{self.url}/api/v1{path}", params=params).raise_for_status().json()

    def open(self, path: str) -> None:
        self.page.goto(self.url + path, wait_until="commit")

    def drawn(self, name: str) -> float:
        """Seconds from navigation until what the page marks with this name was on the screen."""
        self.page.wait_for_function("name => window.drawn[name] > 0", arg=name)
        return float(self.page.evaluate("name => window.drawn[name]", name)) / 1e3

    def clicked_open(self) -> float:
        """Seconds from a click on the first card until the clip's first frame was on the screen."""
        self.page.get_by_role("gridcell").first.click()
        return self.drawn("first-frame") - float(self.page.evaluate("() => window.clicked")) / 1e3

    def seek_to_end(self, frames: int) -> float:
        """Seconds from the key until the last frame's own block had come and was drawn."""
        self.page.locator(".stage").focus()
        self.page.keyboard.press("End")
        self.page.wait_for_function(ARRIVED, arg=f"last={frames}&space=positions")
        found = self.page.evaluate(DRAWN_AFTER, f"last={frames}&space=positions")
        return float(found - self.page.evaluate("() => window.pressed")) / 1e3

    def scripts(self) -> list[str]:
        """Names of the scripts that were fetched so far."""
        found: list[str] = self.page.evaluate(
            "() => performance.getEntriesByType('resource').map(one => one.name).filter(one => one.endsWith('.js'))"
        )
        return [name.rpartition("/")[2] for name in found]

    def resident(self) -> float:
        """MB of memory of the largest renderer process, arrays of numbers and what the browser keeps included."""
        devtools = self.browser.new_browser_cdp_session()
        processes = devtools.send("SystemInfo.getProcessInfo")["processInfo"]
        devtools.detach()
        return max(_resident(int(one["id"])) for one in processes if one["type"] == "renderer")

    def heap(self) -> float:
        """MB of JavaScript that are in use, once what nobody holds is gone."""
        for _ in range(3):
            self._devtools.send("HeapProfiler.collectGarbage")
        found = self._devtools.send("Performance.getMetrics")["metrics"]
        return next(float(one["value"]) for one in found if one["name"] == "JSHeapUsedSize") / 1e6

    @contextmanager
    def watched(self) -> Iterator[Watched]:
        """What the page's main thread does meanwhile."""
        found = Watched()
        self.page.evaluate("() => { longTasks.length = 0; frameScripts.length = 0; }")
        self.browser.start_tracing(page=self.page, categories=["toplevel", "devtools.timeline"])
        yield found
        trace = json.loads(self.browser.stop_tracing())["traceEvents"]
        found.long_tasks = [float(one) for one in self.page.evaluate("() => longTasks")]
        found.scripts = sorted(float(one) for one in self.page.evaluate("() => frameScripts.slice(1)"))
        found.processor, found.script_processor = _processor_times(trace)


@dataclass
class Watched:
    """ms. Other work of the machine makes tasks long by the clock; by processor time they are what they are."""

    long_tasks: list[float] = field(default_factory=list)
    """By the clock, those above 50 ms."""
    scripts: list[float] = field(default_factory=list)
    """Of each frame that was drawn, all callbacks together, by the clock; sorted."""
    processor: float = 0.0
    """The longest task by processor time."""
    script_processor: float = 0.0
    """Of all callbacks of frames together, by processor time."""


def _processor_times(trace: list[dict[str, Any]]) -> tuple[float, float]:
    """Of the busiest renderer's main thread: ms of the longest task, and of all callbacks of frames."""
    mains = {
        (one["pid"], one["tid"])
        for one in trace
        if one["name"] == "thread_name" and one["args"]["name"] == "CrRendererMain"
    }
    own = [one for one in trace if one["ph"] == "X" and (one["pid"], one["tid"]) in mains]
    tasks = [one.get("tdur", 0) for one in own if one["name"].endswith("RunTask")]
    scripts = [one.get("tdur", 0) for one in own if one["name"] == "FireAnimationFrame"]
    return max(tasks, default=0) / 1e3, sum(scripts) / 1e3


def _resident(process: int) -> float:
    try:
        pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


ARRIVED = "part => performance.getEntriesByType('resource').some(one => one.name.includes(part) && one.responseEnd)"
DRAWN_AFTER = """part => new Promise(done => {
  const { responseEnd } = performance.getEntriesByType("resource").find(one => one.name.includes(part));
  // The frame after the block came: it was drawn by now.
  requestAnimationFrame(now => done(Math.min(now, responseEnd + 1000 / 30)));
})"""


def seconds_asked(name: str, usual: float) -> float:
    """How long to do something: as an environment variable says."""
    return float(os.environ.get(name, usual))
