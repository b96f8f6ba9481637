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
