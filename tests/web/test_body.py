"""The body of a clip in a real browser: quantities as curves, thresholds that write questions."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = one_door


def numbers(studio: Served, uuid: str, quantity: str) -> np.ndarray:
    """What the service says of a quantity in every frame."""
    with studio.client() as client:
        answer = client.get(f"/documents/{uuid}/frames", params={"quantity": quantity, "format": "npy"})
        return np.frombuffer(answer.content[-8 * studio.get(f"/documents/{uuid}")["frames"] :])


@pytest.mark.slow
def test_a_threshold_on_a_curve_writes_the_question(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(60))
    page = visit.open(f"/clips/{uuid}?f=5&sel=left_foot&tab=body")
    ready(page)
    page.get_by_label("Measurement").select_option("angle")
    expect(page.get_by_label("Angle", exact=True)).to_have_value("left-knee-flexion")
    plot = page.get_by_role("img", name="angle:left-knee-flexion")
    expect(plot).to_be_visible()
    page.wait_for_url(re.compile("quantity=angle%3Aleft-knee-flexion"))
    degrees = numbers(studio, uuid, "angle:left-knee-flexion")
    limit = round(float(np.median(degrees)), 3)
    field = page.get_by_role("spinbutton", name="Threshold")
    field.fill(str(limit))
    field.press("Enter")
    told = page.get_by_role("status").filter(has_text=f"{int((degrees > limit).sum())} of 60 frames")
    expect(told).to_be_visible()
    question = page.locator(".code-line code").first
    expect(question).to_have_text(f"//frame[mo:angle('left-knee-flexion') > {limit:g}]")
    box = plot.locator(".u-over").bounding_box()
    taken = [part for part in range(0, 101, 2) if _moves(page, box, part / 100, field)]
    assert taken, "somewhere the line is taken hold of"
    page.get_by_role("button", name="below").click()
    found = re.fullmatch(r"//frame\[mo:angle\('left-knee-flexion'\) < (-?[\d.]+)\]", question.inner_text())
    assert found is not None
    assert float(found[1]) != limit
    page.get_by_role("button", name="Search the library").click()
    hits = int((degrees < float(found[1])).sum())
    expect(
        page.get_by_text(re.compile(rf"^{hits:,} frames? in ")) if hits else page.get_by_text("No matches")
    ).to_be_visible()


def _moves(page: Any, box: Any, part: float, field: Any) -> bool:
    """Whether a short drag up from a height of the plot moves the threshold."""
    before = field.input_value()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] * part
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 4)
    page.mouse.up()
    return bool(field.input_value() != before)


@pytest.mark.fuzz
def test_the_floor_is_set_and_taken_back(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(60))
    guessed = studio.get(f"/documents/{uuid}/calibration")["floor"]
    page = visit.open(f"/clips/{uuid}?tab=body&quantity=height:left_foot")
    ready(page)
    page.get_by_text("Calibration").click()
    floor = page.get_by_label("Floor")
    floor.fill("2.5")
    floor.press("Enter")
    expect(page.get_by_text("revision 2", exact=True)).to_be_visible()
    assert studio.get(f"/documents/{uuid}/calibration")["floor"]["value"] == 2.5
    expect(page.get_by_label("Floor")).to_have_value("2.5")
    page.get_by_label("Floor").fill("")
    page.get_by_label("Floor").press("Enter")
    expect(page.get_by_text("revision 3", exact=True)).to_be_visible()
    assert studio.get(f"/documents/{uuid}/calibration")["floor"] == guessed
