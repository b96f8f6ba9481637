"""What leaves the studio as files: under which names, in which unit, and what is not offered."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import urlencode

import pytest

from tests.builders import ASF, amc
from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect


def saved(page: Any, item: Any) -> str:
    with page.expect_download() as download:
        item.click()
    return str(download.value.suggested_filename)


@pytest.mark.slow
@one_door
def test_answers_and_clips_are_saved_under_names_of_their_own(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(30), label="kick:1-10", unit="cm")
    visit.page.route("**/xpath/complete?*", lambda one: one.fulfill(json={"first": 0, "items": []}))
    page = visit.open("/xpath?q=//frame[motion_name='kick']")
    for form in ("XML", "NDJSON", "CSV"):
        page.get_by_role("button", name="Export all").click()
        item = page.get_by_role("menuitem", name=form, exact=True)
        assert saved(page, item) == f"frame-motion-name-kick.{form.lower()}"
    page.goto(f"{studio.url}/clips/{uuid}")
    ready(page)
    names = {"CSV": "kick.csv", "NumPy": "kick.npz", "MCML": "kick.mcml", "glTF": "kick.glb", "For Blender": "kick.bvh"}
    for text, name in names.items():
        page.get_by_role("button", name="Export").click()
        assert saved(page, page.get_by_role("menuitem", name=re.compile(f"^{text}"))) == name


@pytest.mark.slow
@one_door
def test_a_guessed_unit_is_told_where_it_matters_and_confirmed_there(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("person.bvh", walk(30).replace(b"OFFSET 0 0 0", b"OFFSET 0 45 0"))
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.get_by_role("button", name="Export").click()
    item = page.get_by_role("menuitem", name=re.compile("^glTF"))
    expect(item).to_contain_text("unit unknown, read as m")
    confirm = page.get_by_role("menuitem", name=re.compile("^Confirm (mm|cm|m|inch)"))
    if not confirm.count():
        page.get_by_role("menuitem", name=re.compile("^Set unit")).click()
        page.get_by_role("combobox", name="Unit", exact=True).select_option("cm")
    else:
        confirm.click()
    expect(page.locator(".passport")).not_to_contain_text("unit unknown")
    page.get_by_role("button", name="Export").click()
    expect(item).not_to_contain_text("unit unknown")


@one_door
def test_what_needs_a_frame_rate_is_not_offered_until_it_is_given(visit: Visit, studio: Served) -> None:
    with studio.client() as client:
        files = [("file", ("leg.asf", ASF)), ("file", ("leg.amc", amc(4)))]
        uuid = client.post("/documents", files=files).json()["documents"][0]["id"]
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.get_by_role("button", name="Export").click()
    bvh = page.get_by_role("menuitem", name=re.compile("^BVH"))
    expect(bvh).to_have_attribute("aria-disabled", "true")
    expect(bvh).to_contain_text("needs a frame rate")
    page.get_by_role("menuitem", name=re.compile("^Set frame rate")).click()
    page.get_by_label("Frame rate").fill("60")
    page.get_by_label("Frame rate").press("Enter")
    expect(page.locator(".passport")).to_contain_text("60 Hz")
    page.get_by_role("button", name="Export").click()
    expect(bvh).to_have_attribute("href", re.compile("format=bvh"))


@pytest.mark.slow
@one_door
def test_a_value_is_asked_for_once(visit: Visit, studio: Served) -> None:
    """Without a refusal on the way: a visit fails at any that it does not want."""
    studio.upload("kick.bvh", walk(30))
    asked: list[str] = []
    page = visit.page
    # Names for the builder are another matter.
    page.route("**/xpath/complete?*", lambda one: one.fulfill(json={"first": 0, "items": []}))
    page.on("request", lambda one: asked.append(one.url) if "/xpath?q" in one.url and "/api/" in one.url else None)
    for q, shown in (("count(//frame)", "1 value"), ("//bone/name", "3 items"), ("1 + 1", "1 value")):
        asked.clear()
        visit.open(f"/xpath?{urlencode({'q': q})}")
        expect(page.get_by_role("status").filter(has_text=shown)).to_be_visible()
        assert len(asked) == 1, asked


@one_door
def test_an_unknown_address_is_a_page_and_the_skip_link_leads_to_the_content(visit: Visit, studio: Served) -> None:
    visit.wanted = {404}
    page = visit.open("/nowhere")
    expect(page.get_by_role("heading", name="Page not found.")).to_be_visible()
    page.get_by_role("link", name="Go to the library").click()
    expect(page).to_have_url(re.compile("/library$"))
    page.goto(f"{studio.url}/xpath")
    expect(page.get_by_role("textbox", name="XPath")).to_be_focused()
    page.get_by_role("link", name="Skip to content").focus()
    page.keyboard.press("Enter")
    expect(page.locator("main")).to_be_focused()
    expect(page).to_have_url(re.compile("/xpath"))
