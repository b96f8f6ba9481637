"""The first start: the demo library alone, three ways to begin; gone when it is closed, or when there are own clips."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.web.conftest import Served, serve, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect


@pytest.fixture(params=["open", pytest.param("session", marks=pytest.mark.fuzz)])
def demo_studio(demo_library: Path, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Served]:
    yield from serve(demo_library, tmp_path, closed=request.param == "session")


@pytest.mark.slow
def test_the_first_start(demo_studio: Served, visit_of: Any) -> None:
    page = visit_of(demo_studio).open("/")
    welcome = page.get_by_role("region", name="Your motion library")
    expect(welcome.get_by_role("img", name=re.compile("^dance_1 is playing"))).to_be_visible()
    expect(page.get_by_role("gridcell").first).to_be_visible()
    welcome.get_by_role("link", name=re.compile("^Try a query")).click()
    expect(page.get_by_role("status").filter(has_text=re.compile(r"[1-9]\d* frames in \d+ ranges"))).to_be_visible()
    page.go_back()
    welcome.get_by_role("link", name=re.compile("^Compose a motion")).click()
    expect(page.get_by_role("group", name="Segments").get_by_role("button", name="Segment")).to_have_count(2)
    expect(page.get_by_role("status").filter(has_text="in 2 segments")).to_be_visible()
    page.goto(demo_studio.url)
    with page.expect_file_chooser():
        welcome.get_by_role("button", name=re.compile("^Import your files")).click()
    # A filter is a wish to see clips.
    page.goto(f"{demo_studio.url}/library?q=walk")
    expect(page.get_by_role("status").filter(has_text="clips")).to_be_visible()
    expect(welcome).to_have_count(0)
    page.goto(demo_studio.url)
    welcome.get_by_role("button", name="Do not show again").click()
    expect(welcome).to_have_count(0)
    page.reload()
    expect(page.get_by_role("gridcell").first).to_be_visible()
    expect(welcome).to_have_count(0)


@pytest.mark.slow
@pytest.mark.parametrize("demo_studio", ["open"], indirect=True)
def test_own_clips_end_it(demo_studio: Served, visit_of: Any) -> None:
    page = visit_of(demo_studio).open("/")
    welcome = page.get_by_role("region", name="Your motion library")
    expect(welcome).to_be_visible()
    demo_studio.upload("mine.bvh", walk(10))
    expect(welcome).to_have_count(0)


def test_a_tour_leads_over_the_pages_by_keys_and_is_left(open_studio: Served, visit_of: Any) -> None:
    open_studio.upload("walk.bvh", walk(20))
    page = visit_of(open_studio).open("/library")
    expect(page.get_by_role("gridcell")).to_have_count(1)
    tour = page.get_by_role("region", name="Guided tour")
    expect(tour).to_have_count(0)  # It never begins by itself.
    page.get_by_role("button", name="Keyboard shortcuts").click()
    page.get_by_role("button", name="Start the guided tour").press("Enter")
    go_on = tour.get_by_role("button", name="Show next")
    seen = []
    for step in range(1, 7):
        expect(tour).to_contain_text(f"{step} of 7")
        expect(go_on).to_be_focused()
        box, below = page.locator("main").bounding_box(), tour.bounding_box()
        assert box["y"] + box["height"] <= below["y"] + 1
        seen.append(page.url.removeprefix(open_studio.url))
        page.keyboard.press("Enter")
    assert seen == ["/library", "/library?folders=project", "/xpath", "/compose", "/measure", "/dance"]
    tour.get_by_role("button", name="Go back").click()
    expect(tour).to_contain_text("6 of 7")
    tour.get_by_role("button", name="Close tour").click()
    expect(tour).to_have_count(0)
    page.reload()
    expect(tour).to_have_count(0)
