"""What was done, as the studio tells it: narrowed, heard while one looks, page after page, with a way to the clip."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.web.conftest import Served, Visit, one_door, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect


@pytest.mark.slow
@one_door
def test_what_was_done_is_listed_narrowed_and_heard(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("walk.bvh", walk(), project="gait")
    with visit.page.expect_response(re.compile("/api/v1/events")):
        page = visit.open("/settings/activity")
    rows = page.locator(".activity li")
    expect(rows.filter(has_text="imported").filter(has_text="walk")).to_be_visible()
    # What others do is heard.
    with studio.client() as client:
        client.post(f"/documents/{uuid}/comments", json={"text": "a slide"}).raise_for_status()
    expect(rows.filter(has_text="commented on")).to_be_visible()
    page.get_by_label("Kind").select_option("comment")
    expect(rows.filter(has_text="imported")).to_have_count(0)
    expect(rows).to_have_count(1)
    page.get_by_label("Person").fill("nobody")
    page.keyboard.press("Enter")
    expect(page.get_by_text("No matching activity.")).to_be_visible()
    page.go_back()
    page.get_by_label("Kind").select_option("document")
    page.get_by_label("Project", exact=True).select_option("gait")
    page.get_by_label("Period").select_option("7")
    rows.get_by_role("link", name="walk").click()
    expect(page).to_have_url(re.compile(rf"/clips/{uuid}\?rev=1"))


@one_door
def test_more_of_what_was_done_is_a_page_away(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("walk.bvh", walk())
    with studio.client() as client:
        for number in range(51):
            client.post(f"/documents/{uuid}/comments", json={"text": str(number)}).raise_for_status()
    page = visit.open("/settings/activity")
    rows = page.locator(".activity li")
    expect(rows).to_have_count(50)
    page.get_by_role("button", name="More").click()
    expect(rows.filter(has_text="imported")).to_be_visible()
    expect(page.get_by_role("button", name="More")).to_have_count(0)
