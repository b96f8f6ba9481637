"""Take the pictures of the documentation from a studio with the demo library: `python -m tests.web.pictures`."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

from mcml_service.actions.importing.load_demo import load_demo
from mcml_service.clips.derive import derive_missing
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.web.conftest import FLAGS, chromium, serve

FOLDER = Path(__file__).resolve().parents[2] / "docs/pictures"
SIZE = {"width": 1280, "height": 800}
SCHEMES = ("dark", "light")
QUERY = "//frame[mo:height('left_hand') > mo:height('Head')]"


def main() -> None:
    """Write a picture of each page in both colour schemes."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        store = folder / "demo.db"
        database = Database(f"sqlite:///{store}")
        database.migrate()
        load_demo(database, Settings())
        derive_missing(database, lambda done, of: None)
        database.close()
        (folder / "served").mkdir()
        FOLDER.mkdir(exist_ok=True)
        for served in serve(store, folder / "served", closed=False):
            clips = {item["name"]: item["id"] for item in served.get("/documents", limit=500)["items"]}
            clip = next(clips[name] for name in sorted(clips) if name.startswith("dance"))
            pages = {
                "library": "/library",
                "clip": f"/clips/{clip}?f=20&sel=left_up_leg",
                "xpath": f"/xpath?q={QUERY}",
            }
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(executable_path=chromium(), args=FLAGS)
                for scheme in SCHEMES:
                    _take(browser, served.url, pages, scheme)
                browser.close()


def _take(browser: Any, url: str, pages: dict[str, str], scheme: str) -> None:
    context = browser.new_context(viewport=SIZE, locale="en", color_scheme=scheme, reduced_motion="reduce")
    page = context.new_page()
    for name, path in pages.items():
        page.goto(url + path)
        page.wait_for_load_state("networkidle")
        # The second time queries find their columns, as they do in a library that has been open for a while.
        page.reload()
        page.wait_for_function(
            "() => document.querySelector('main')?.childElementCount && !document.querySelector('.busy')"
        )
        page.wait_for_load_state("networkidle")
        path_of_picture = FOLDER / f"{name}-{scheme}.png"
        page.screenshot(path=path_of_picture)
        print(path_of_picture.relative_to(FOLDER.parents[1]))
    context.close()


if __name__ == "__main__":
    sys.exit(main())
