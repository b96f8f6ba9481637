"""An empty library: every page says what it makes, and shows its material after *Try it with demo clips*."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.web.conftest import Served, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect

MAKES = {
    "/library": "All your motion clips in one place",
    "/xpath": "Find frames by label",
    "/compose": "Join frame ranges",
    "/retarget": "Give the motion of one clip",
    "/motion-matching": "A body follows a path",
    "/reach": "New reaching motions",
    "/dance": "New dances",
    "/faces": "Facial animations",
    "/measure": "Measure any quantity",
}


def try_demo(page: Any) -> None:
    page.get_by_role("button", name="Try it with demo clips").click()


@pytest.mark.slow
def test_every_page_of_an_empty_library_says_what_it_makes(open_studio: Served, visit_of: Any) -> None:
    visit = visit_of(open_studio)
    formats = [one["label"] for one in open_studio.get("/formats")["items"] if one["reads"]]
    for path, sentence in MAKES.items():
        page = visit.open(path)
        expect(page.get_by_text(sentence)).to_be_visible()
        expect(page.get_by_role("button", name="Try it with demo clips")).to_be_enabled()
        listed = page.get_by_role("list", name="Supported formats").get_by_role("listitem")
        expect(listed.filter(has_text=re.compile(r"^\w"))).to_have_count(len(formats))
        with page.expect_file_chooser():
            page.get_by_role("button", name="Import files").click()


@pytest.mark.slow
def test_the_library_shows_cards_and_takes_the_demo_once(open_studio: Served, visit_of: Any) -> None:
    page = visit_of(open_studio).open("/")
    try_demo(page)
    expect(page.get_by_role("gridcell").first).to_be_visible(timeout=90_000)
    expect(page.get_by_role("region", name="Your motion library")).to_be_visible()
    # The library fills while the other parts are loaded.
    expect(page.get_by_role("status").filter(has_text="225 clips")).to_be_visible(timeout=90_000)
    expect(page.get_by_text("Loading demo clips")).to_have_count(0)
    assert open_studio.get("/projects")["items"] == ["demo", "demo-dance", "demo-face", "demo-reach", "demo-walk"]
    # Other pages then load nothing twice.
    page.goto(f"{open_studio.url}/motion-matching")
    try_demo(page)
    expect(page.get_by_role("status").filter(has_text="of 7 clips")).to_be_visible(timeout=60_000)
    assert open_studio.get("/documents", limit=1)["total"] == 225


@pytest.mark.slow
def test_pages_show_their_demo_clips(open_studio: Served, visit_of: Any) -> None:
    """Each page loads the part of the demo library that it shows."""
    visit = visit_of(open_studio)
    page = visit.open("/xpath")
    try_demo(page)
    expect(page.get_by_role("status").filter(has_text=re.compile(r"[1-9]\d* frames in \d+ ranges"))).to_be_visible(
        timeout=60_000
    )
    page = visit.open("/compose")
    try_demo(page)
    expect(page.get_by_role("status").filter(has_text="in 2 segments")).to_be_visible(timeout=60_000)
    page = visit.open("/retarget")
    try_demo(page)
    expect(page.get_by_role("button", name="Target character: wave_2")).to_be_visible(timeout=60_000)
    page = visit.open("/dance")
    try_demo(page)
    expect(page.get_by_role("option", name=re.compile("^Beat 1,")).first).to_be_visible(timeout=60_000)
    page = visit.open("/measure")
    try_demo(page)
    expect(page.get_by_role("region", name="Curves", exact=True)).to_be_visible(timeout=60_000)
    assert {"demo", "demo-dance", "demo-walk"} == set(open_studio.get("/projects")["items"])


@pytest.mark.slow
@pytest.mark.usefixtures("lent_workers")
@pytest.mark.parametrize(("path", "lack"), [("/faces", "has markers yet"), ("/reach", "has numeric properties yet")])
def test_pages_say_what_the_clips_of_a_library_lack(open_studio: Served, visit_of: Any, path: str, lack: str) -> None:
    open_studio.upload("mine.bvh", walk(10))
    page = visit_of(open_studio).open(path)
    expect(page.get_by_role("note").filter(has_text=lack)).to_be_visible()
    try_demo(page)
    expect(page).to_have_url(re.compile(rf"{path}/\w+"), timeout=120_000)
