"""What a page shows is the answer to what it asks now: another question, or a refusal, clears what was there."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect


@contextmanager
def held_at(page: Any, pattern: str) -> Iterator[list[Any]]:
    """The first request to an address that what is done within makes. It is held until it is continued or fulfilled."""
    held: list[Any] = []
    page.route(re.compile(pattern), lambda one: held.append(one))
    with page.expect_request(re.compile(pattern)):
        yield held


@pytest.mark.slow
@one_door
def test_a_curve_is_gone_when_another_is_asked_for(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(), unit="cm")
    visit.wanted = {422}
    page = visit.open(f"/clips/{uuid}?tab=body&quantity=height:left_foot")
    ready(page)
    curve = page.locator(".graph-plot")
    expect(curve).to_have_attribute("aria-label", "height:left_foot")
    with held_at(page, r"/frames\?.*quantity=speed") as held:
        page.get_by_label("Measurement").select_option("speed")
    expect(curve).to_have_count(0)
    refusal = '{"title": "Query error", "detail": "no speed here", "status": 422}'
    held[0].fulfill(status=422, content_type="application/problem+json", body=refusal)
    expect(page.get_by_role("alert")).to_contain_text("no speed here")
    expect(curve).to_have_count(0)
    page.get_by_label("Measurement").select_option("height")
    expect(curve).to_have_attribute("aria-label", "height:left_foot")
    expect(page.get_by_role("alert")).to_have_count(0)


@pytest.mark.slow
@one_door
def test_an_answer_is_gone_when_another_question_runs(visit: Visit, studio: Served) -> None:
    studio.upload("kick.bvh", walk(), label="kick:1-10")
    page = visit.open("/xpath?q=//frame[motion_name='kick']")
    found = page.get_by_role("status").filter(has_text="10 frames in 1 range")
    expect(found).to_be_visible()
    page.get_by_role("textbox", name="XPath").click()
    page.keyboard.press("Control+a")
    page.keyboard.type("//frame[@id<3]", delay=1)
    page.keyboard.press("Escape")
    # What is typed is not asked yet: copies and exports are of the answer that is shown.
    page.get_by_role("button", name="Export all").click()
    item = page.get_by_role("menuitem", name="CSV")
    expect(item).to_have_attribute("href", re.compile("motion_name"))
    # Completions may come late, and take a key that is pressed for the menu.
    item.press("Escape")
    expect(item).to_have_count(0)
    with held_at(page, r"/xpath\?") as held:
        page.keyboard.press("Control+Enter")
    expect(found).to_have_count(0)
    held[0].continue_()
    expect(page.get_by_role("status").filter(has_text="2 frames in 1 range")).to_be_visible()


@one_door
def test_revisions_are_compared_by_the_frames_that_were_kept(visit: Visit, studio: Served) -> None:
    """A crop moves no joint, wherever its frames stand now."""
    uuid = studio.upload("kick.bvh", walk(60))
    with studio.client() as client:
        asked = {"edits": [{"do": "keep", "first": 21, "last": 50}], "renumber": True}
        client.post(f"/documents/{uuid}/frames", json=asked, headers={"if-match": "1"}).raise_for_status()
        edit = {"frames": [{"first": 10, "columns": ["left_low_leg.Rx"], "values": [[70.0]]}]}
        client.post(f"/documents/{uuid}/changes", json=edit, headers={"if-match": "2"}).raise_for_status()
    page = visit.open(f"/clips/{uuid}?f=5&tab=history")
    ready(page)
    page.get_by_label("Select revision 1").check()
    page.get_by_label("Select revision 2").check()
    told = page.get_by_role("region", name="Difference")
    expect(told).to_contain_text("Compared: 30 frames in both. Removed: 30, added: 0.")
    expect(told).to_contain_text("No joint moved.")
    page.get_by_label("Select revision 2").uncheck()
    page.get_by_label("Select revision 3").check()
    joint = told.get_by_role("button", name=re.compile(r"^left_foot: .* cm at frame 10$"))
    joint.click()
    expect(page.get_by_label("Frame", exact=True)).to_have_value("10")
