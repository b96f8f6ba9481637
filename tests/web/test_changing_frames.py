"""Loops, speed and extraction in a real browser: seen as they move, saved here or as clips of their own."""

from __future__ import annotations

import re
from typing import Any

import pytest

from mcml.formats import FORMATS
from mcml_service.demo import body
from tests.web.conftest import Served, Visit, one_door
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = one_door


@pytest.fixture
def steps(studio: Served) -> str:
    clip = body.clip("walk", 170.0, *body.walk(170.0, 4.0, 1.0, 6.0))
    return str(studio.upload("steps.bvh", b"".join(FORMATS["bvh"].write(clip, "bvh"))))


def choose(page: Any, item: str) -> Any:
    page.get_by_role("toolbar", name="Play").get_by_role("button", name="Frames").click()
    page.get_by_role("menuitem", name=item).click()
    return page.get_by_role("dialog", name=item)


def clips(studio: Served, name: str) -> list[dict[str, Any]]:
    items: list[dict[str, Any]] = studio.get("/documents", limit=1000)["items"]
    return [item for item in items if item["name"] == name]


@pytest.mark.slow
def test_a_loop_is_seen_and_saved_as_its_own_clip(visit: Visit, studio: Served, steps: str) -> None:
    page = visit.open(f"/clips/{steps}")
    ready(page)
    dialog = choose(page, "Make a loop")
    expect(dialog.get_by_role("status", name="Preview")).to_contain_text("are the loop")
    expect(dialog.get_by_role("img", name="Preview")).to_be_visible()
    dialog.get_by_label("In place").check()
    expect(dialog.get_by_role("textbox", name="Name")).to_have_value("steps loop")
    dialog.get_by_role("button", name="Save as clip").click()
    page.get_by_role("button", name="Open", exact=True).last.click()
    expect(page).not_to_have_url(re.compile(steps))
    ready(page)
    (loop,) = clips(studio, "steps loop")
    assert loop["frames"] < 240
    assert studio.get(f"/documents/{loop['id']}")["revision"] == 2
    assert studio.get(f"/documents/{steps}")["revision"] == 1, "the clip itself stays"


@pytest.mark.slow
def test_frames_are_played_faster_by_a_curve(visit: Visit, studio: Served, steps: str) -> None:
    page = visit.open(f"/clips/{steps}")
    ready(page)
    dialog = choose(page, "Change speed")
    notes = dialog.get_by_role("status", name="Preview")
    expect(notes).to_contain_text("240 before, 240 after")
    first = dialog.get_by_label("Factor at the start")
    first.fill("2")
    first.blur()
    expect(dialog.get_by_label("at the end")).to_have_value("2")
    expect(notes).to_contain_text("240 before, 121 after")
    last = dialog.get_by_label("at the end")
    last.fill("0.5")
    last.blur()
    expect(first).to_have_value("2")
    expect(notes).not_to_contain_text("121 after")
    dialog.get_by_role("button", name="Apply").click()
    expect(page.get_by_text("revision 2", exact=True)).to_be_visible()
    changed = studio.get(f"/documents/{steps}")["frames"]
    assert 121 < changed < 480
    page.get_by_role("button", name="Undo").last.click()
    expect(page.get_by_text("revision 3", exact=True)).to_be_visible()
    assert studio.get(f"/documents/{steps}")["frames"] == 240


@pytest.mark.slow
def test_the_loop_is_extracted_and_the_menu_stays_in_the_window(visit: Visit, studio: Served, steps: str) -> None:
    page = visit.open(f"/clips/{steps}?in=41&out=100")
    ready(page)
    page.get_by_role("toolbar", name="Play").get_by_role("button", name="Frames").click()
    last = page.get_by_role("menuitem", name="Repair frames")
    last.scroll_into_view_if_needed()
    box = page.get_by_role("menu", name="Edit frames").bounding_box()
    assert box["y"] >= 0
    assert box["y"] + box["height"] <= page.viewport_size["height"]
    page.get_by_role("menuitem", name="Extract frames").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("textbox", name="Name").fill("two steps")
    dialog.get_by_role("button", name="Save").click()
    expect(page.get_by_text("Saved as two steps")).to_be_visible()
    (made,) = clips(studio, "two steps")
    assert made["frames"] == 60
