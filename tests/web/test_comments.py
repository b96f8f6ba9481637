"""Comments in the studio: said about a frame and a joint, heard at once, and a way to what they are about."""

from __future__ import annotations

from typing import Any

import pytest

from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = one_door


@pytest.mark.slow
def test_a_comment_leads_to_its_frame_and_joint(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("slide.bvh", walk())
    page = visit.open(f"/clips/{uuid}?f=5&sel=left_low_leg&tab=comments")
    ready(page)
    expect(page.get_by_text("No comments yet")).to_be_visible()
    page.get_by_label("Comment. @name").fill("the foot <i>slides</i>")
    page.get_by_role("button", name="Comment", exact=True).click()
    place = page.get_by_role("button", name="Frame 5, left_low_leg")
    expect(place).to_be_visible()
    expect(page.get_by_text("the foot <i>slides</i>")).to_be_visible()
    # What somebody else says is heard.
    with studio.client() as client:
        client.post(f"/documents/{uuid}/comments", json={"text": "and here", "first": 2}).raise_for_status()
    page.get_by_role("button", name="Frame 2").click()
    expect(page.get_by_label("Frame 2", exact=True)).to_be_visible()
    place.click()
    expect(page.get_by_label("Frame 5", exact=True)).to_be_visible()
    page.get_by_role("listitem").filter(has_text="and here").get_by_role("button", name="Resolve", exact=True).click()
    expect(page.get_by_text("and here")).to_have_count(0)
    page.get_by_label("Show 1 resolved").check()
    expect(page.get_by_text("and here")).to_be_visible()
    page.get_by_role("listitem").filter(has_text="and here").get_by_role("button", name="Delete").click()
    expect(page.get_by_text("and here")).to_have_count(0)


@pytest.mark.slow
def test_a_comment_follows_its_frames_into_later_revisions(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("slide.bvh", walk())
    with studio.client() as client:
        for text, first in (("stays", 30), ("goes", 5)):
            client.post(f"/documents/{uuid}/comments", json={"text": text, "first": first}).raise_for_status()
        edit = {"edits": [{"do": "delete", "first": 1, "last": 10}]}
        client.post(f"/documents/{uuid}/frames", json=edit, headers={"If-Match": '"1"'}).raise_for_status()
    page = visit.open(f"/clips/{uuid}?tab=comments")
    ready(page)
    page.get_by_role("button", name="Frame 20", exact=True).click()
    expect(page.get_by_label("Frame 20", exact=True)).to_be_visible()
    page.get_by_role("link", name="Frame 5 · revision 1").click()
    ready(page)
    expect(page.get_by_label("Frame 5", exact=True)).to_be_visible()


@pytest.mark.slow
def test_tabs_that_do_not_fit_are_in_a_menu(visit: Visit, studio: Served) -> None:
    page = visit.open(f"/clips/{studio.upload('slide.bvh', walk())}")
    ready(page)
    tabs = page.get_by_role("tablist", name="Panels")
    assert tabs.evaluate("box => box.scrollWidth <= box.clientWidth")
    page.get_by_role("button", name="More:").click()
    page.get_by_role("menuitem", name="Info").click()
    info = tabs.get_by_role("tab", name="Info")
    expect(info).to_be_focused()
    expect(page.get_by_role("tabpanel", name="Info")).to_be_visible()
    # Arrows reach those in the menu, too.
    info.press("ArrowLeft")
    expect(tabs.get_by_role("tab", name="Video")).to_be_focused()
    page.set_viewport_size({"width": 1920, "height": 1080})
    page.get_by_role("separator", name="Panels").focus()
    for _ in range(24):
        page.keyboard.press("ArrowLeft")
    expect(tabs.get_by_role("tab")).to_have_count(11)
