"""Clips that have no beats leave the bench to the others, and say why."""

from __future__ import annotations

import re
from typing import Any

import pytest

from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.settings import Settings
from tests.web.conftest import Served, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = pytest.mark.usefixtures("lent_workers")


@pytest.mark.slow
def test_clips_without_beats_are_left_out_by_name(open_studio: Served, visit_of: Any) -> None:
    """One too short, one with too few frames a second, one without a frame rate: none blocks the bench, each is named
    with the reason."""
    clips = [dance_clip("groove", bars=8, seed=1, name="groove 1").clip]
    add_clips(open_studio.database, Settings(), "dances", clips, (), "")
    good = str(open_studio.get("/documents", project="dances")["items"][0]["id"])
    short = open_studio.upload("blink.bvh", walk(20))
    slow = open_studio.upload("crawl.bvh", walk(60).replace(b"Frame Time: 0.0083333", b"Frame Time: 0.2"))
    untimed = open_studio.upload("still.bvh", walk(200).replace(b"Frame Time: 0.0083333\n", b""))
    page = visit_of(open_studio).open(f"/dance?doc={short}&doc={untimed}&doc={good}&doc={slow}")
    expect(page.locator(".bench-row")).to_have_count(1)
    expect(page.get_by_role("article", name="groove 1").locator("[data-bars]")).to_have_attribute("data-bars", "8")
    expect(page.get_by_role("link", name=re.compile("^blink has 20 frames; beats need at least"))).to_be_visible()
    expect(page.get_by_role("link", name=re.compile("^crawl has 5 frames a second"))).to_be_visible()
    expect(page.get_by_text("Excluded.")).to_have_count(3)
    expect(page.get_by_role("form", name="still")).to_contain_text("No frame rate, so no tempo. Excluded.")
    expect(page.get_by_role("alert")).to_have_count(0)
    expect(page.get_by_role("button", name="Jobs")).to_have_count(0)
    # What is made of the bench is made of the others.
    with page.expect_request(lambda asked: asked.url.endswith("/analyses/motion-graph")) as asked:
        page.get_by_role("button", name="Build motion graph").click()
    assert asked.value.post_data_json["inputs"]["documents"] == [good]
    page.wait_for_selector(".bench-canvas[data-laid]")
