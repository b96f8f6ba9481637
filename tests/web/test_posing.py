"""A pose on top of a motion, made in a real browser: parts dragged and typed, previewed, applied, taken back."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest

from tests.motion.bodies.made import person
from tests.web.conftest import Served, Visit, one_door
from tests.web.test_clip_tools import MIDDLE_OF
from tests.web.test_editing import expect_other_picture
from tests.web.test_journeys import ready
from tests.web.test_pages import faults

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = one_door


def places(studio: Served, uuid: str, bone: str) -> np.ndarray:
    """(n, 3) of a joint."""
    with studio.client() as client:
        asked = {"format": "npy", "space": "positions", "bone": bone}
        answer = client.get(f"/documents/{uuid}/frames", params=asked)
        return np.load(io.BytesIO(answer.content))[:, 0]  # type: ignore[no-any-return]


@pytest.mark.slow
def test_a_hand_is_dragged_and_typed_over_frames(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("posed.bvh", person(3, 60))
    before = places(studio, uuid, "right_hand")
    page = visit.open(f"/clips/{uuid}?f=20")
    ready(page)
    page.get_by_role("button", name="axes", exact=True).click()
    page.get_by_role("toolbar").get_by_role("button", name="Edit frames").click()
    page.get_by_role("menuitem", name="Pose the body").press("Enter")
    panel = page.get_by_role("complementary", name="Pose")
    expect(panel.get_by_role("radio", name="Right hand")).to_be_checked()
    expect(panel.get_by_role("button", name="Apply")).to_be_disabled()
    page.wait_for_function(f"() => ({MIDDLE_OF})('--x')")
    x, y = page.evaluate(MIDDLE_OF, "--x")
    picture = page.locator(".stage").screenshot()
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 20, y, steps=4)
    page.mouse.up()
    across = panel.get_by_label("Move along X")
    expect(across).not_to_have_value("0")
    expect_other_picture(page, picture)
    panel.get_by_label("Move along Y").fill("7.5")
    panel.get_by_label("Move along Y").press("Enter")
    panel.get_by_label("Fade (s)").fill("0.1")
    panel.get_by_label("Fade (s)").press("Enter")
    way = [float(across.input_value()), 7.5, 0.0]
    panel.get_by_role("button", name="Apply").click()
    expect(page.get_by_text("revision 2")).to_be_visible()
    expect(panel).to_have_count(0)
    moved = places(studio, uuid, "right_hand") - before
    assert moved[19] == pytest.approx(way, abs=0.1)
    fade = round(0.1 / studio.get(f"/documents/{uuid}")["seconds_per_frame"])
    assert np.flatnonzero(moved.any(axis=1)).tolist() == list(range(19 - fade, 20 + fade))
    page.get_by_role("button", name="Undo").last.click()
    expect(page.get_by_text("revision 3")).to_be_visible()
    assert np.array_equal(places(studio, uuid, "right_hand"), before)


@pytest.mark.slow
def test_another_part_is_chosen_in_the_viewer_and_by_its_name(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("posed.bvh", person(3, 60))
    page = visit.open(f"/clips/{uuid}?f=20&sel=left_foot")
    ready(page)
    page.get_by_role("toolbar").get_by_role("button", name="Edit frames").click()
    page.get_by_role("menuitem", name="Pose the body").press("Enter")
    panel = page.get_by_role("complementary", name="Pose")
    expect(panel.get_by_role("radio", name="Left foot")).to_be_checked()
    assert faults(page) == []
    panel.get_by_role("radio", name="Head").check()
    panel.get_by_label("Move along Y").fill("500")
    panel.get_by_label("Move along Y").press("Enter")
    expect(panel.get_by_role("status")).to_contain_text("head: up to")
    page.get_by_label("Frame", exact=True).fill("1")
    page.get_by_label("Frame", exact=True).press("Enter")
    panel.get_by_role("button", name="Go to frame 20").click()
    expect(page.get_by_label("Frame", exact=True)).to_have_value("20")
    panel.get_by_role("button", name="Reset part").click()
    expect(panel.get_by_text("No part is moved yet.")).to_be_visible()
    panel.get_by_role("button", name="Close").click()
    expect(panel).to_have_count(0)
    assert studio.get(f"/documents/{uuid}")["revision"] == 1
