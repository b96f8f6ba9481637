"""The clip page as it is used: labels within labels, low windows, toasts, what is unknown, and what others saved."""

from __future__ import annotations

import itertools
import math
import re
from typing import Any
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest

from mcml.formats import FORMATS
from mcml_service.demo.walks import walks
from tests.actions.test_measurements import walkway
from tests.builders import ASF, amc
from tests.laboratory.gait_files import gait_file
from tests.laboratory.gait_files import walk as gait_markers
from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect


def dragged(page: Any, box: dict[str, float], to: float, dy: float) -> None:
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + dy)
    page.mouse.down()
    page.mouse.move(box["x"] + to * box["width"], box["y"] + dy, steps=4)
    page.mouse.up()


@pytest.mark.slow
@one_door
def test_a_label_is_drawn_within_another_and_its_name_is_typed(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(60), label="kick:1-60")
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    lane = page.get_by_role("list", name="Labels")
    outer = page.get_by_role("button", name="kick, 1–60")
    # With Shift over the label, then in the free lane below it.
    page.keyboard.down("Shift")
    dragged(page, outer.bounding_box(), 0.6, 10)
    page.keyboard.up("Shift")
    page.keyboard.type("still")
    expect(page.get_by_role("combobox", name="Label")).to_have_value("still")
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name=re.compile("^still, "))).to_be_visible()
    expect(outer).to_be_visible()
    box = lane.bounding_box()
    dragged(page, box, 0.5, box["height"] - 12)
    page.keyboard.type("jog")
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name=re.compile("^jog, "))).to_be_visible()
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()


@pytest.mark.slow
@one_door
def test_in_a_low_window_nothing_lies_over_play(visit: Visit, studio: Served) -> None:
    """720 by 450 pixels are a window of 1440 by 900 at 200 %."""
    uuid = studio.upload("kick.bvh", walk(60), label="kick:1-60")
    visit.page.set_viewport_size({"width": 720, "height": 450})
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.get_by_role("button", name="Play", exact=True).click()
    expect(page.get_by_role("button", name="Pause", exact=True)).to_be_visible()
    parts = [page.locator(name).bounding_box() for name in (".clip-bar", ".viewer", ".transport", ".timeline", ".dock")]
    edges = [(part["y"], part["y"] + part["height"]) for part in parts]
    assert all(above[1] <= below[0] + 1 for above, below in itertools.pairwise(edges)), edges
    page.goto(f"{studio.url}/xpath?q=//frame[motion_name='kick']")
    page.get_by_role("listbox", name="Results").get_by_role("option").first.click()
    page.get_by_role("button", name="Export all").click()


@one_door
def test_a_body_in_a_much_larger_unit_is_seen_as_a_whole(visit: Visit, studio: Served) -> None:
    """A file in centimetres whose unit is stated as metres shows a body of 100 m and more."""
    uuid = studio.upload("walk.bvh", b"".join(FORMATS["bvh"].write(walks()[0], "bvh")), unit="m")
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.locator(".viewer canvas").first.hover()
    page.mouse.wheel(0, -10)
    page.wait_for_url(re.compile("cam="))
    numbers = [float(one) for one in parse_qs(urlsplit(page.url).query)["cam"][0].split(",")]
    assert math.dist(numbers[:3], numbers[3:]) > 150_000  # mm, of a body of 160 m


@one_door
def test_markers_that_are_unseen_at_first_are_looked_at_when_they_come(visit: Visit, studio: Served) -> None:
    """A walker who enters the volume of the cameras after 20 frames, 30 m from the origin."""
    markers = {name: place + np.array([30_000.0, 0.0, 0.0]) for name, place in gait_markers(40).items()}
    for place in markers.values():
        place[:20] = np.nan
    uuid = studio.upload("trial.c3d", gait_file(markers, {}))
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    frame = page.get_by_label("Frame", exact=True)
    frame.fill("30")
    frame.press("Enter")
    page.locator(".viewer canvas").first.hover()
    page.mouse.wheel(0, -10)
    page.wait_for_url(re.compile("cam="))
    numbers = [float(one) for one in parse_qs(urlsplit(page.url).query)["cam"][0].split(",")]
    assert 1_000 < math.dist(numbers[:3], numbers[3:]) < 15_000
    assert 25_000 < math.hypot(*numbers[3:]) < 36_000
    assert numbers[4] > 300  # the middle of the body, not the ground below it


@one_door
def test_toasts_lie_over_no_button(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(60), unit="cm")
    page = visit.open(f"/clips/{uuid}?tab=info")
    ready(page)
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    for _ in range(3):
        page.get_by_role("button", name="Share").click()
        page.get_by_role("menuitem", name="Copy link").click()
    toasts = page.locator(".toast")
    expect(toasts).to_have_count(3)
    covered = page.evaluate(
        """() => {
          const toasts = [...document.querySelectorAll(".toast")].map(one => one.getBoundingClientRect());
          return [...document.querySelectorAll("main button, main a, .bar button, .rail a")].filter(one => {
            const box = one.getBoundingClientRect(), panel = one.closest(".info, main")?.getBoundingClientRect();
            return toasts.some(t => box.width && box.left < t.right && box.right > t.left && box.top < t.bottom
              && box.bottom > t.top && box.bottom <= (panel ?? t).bottom);
          }).map(one => one.outerHTML.slice(0, 100));
        }"""
    )
    assert covered == []


@one_door
def test_the_one_reason_for_a_missing_quantity_stands_with_what_mends_it(visit: Visit, studio: Served) -> None:
    with studio.client() as client:
        files = [("file", ("leg.asf", ASF)), ("file", ("leg.amc", amc(4)))]
        uuid = client.post("/documents", files=files, data={"unit": "cm"}).json()["documents"][0]["id"]
    page = visit.open(f"/clips/{uuid}?tab=body&quantity=speed:Root")
    ready(page)
    expect(page.get_by_role("tabpanel").get_by_text("Frame rate unknown")).to_be_visible()
    page.get_by_role("tabpanel").get_by_role("button", name="Set frame rate").click()
    page.get_by_label("Frame rate").fill("60")
    page.get_by_label("Frame rate").press("Enter")
    expect(page.locator(".passport")).to_contain_text("60 Hz")
    page.goto(f"{studio.url}/clips/{uuid}?tab=body&quantity=speed:Root")
    expect(page.locator(".graph-plot")).to_be_visible()


@one_door
def test_forces_and_model_outputs_of_a_file_are_curves(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("trial.c3d", walkway())
    page = visit.open(f"/clips/{uuid}?tab=body")
    ready(page)
    kind = page.get_by_label("Measurement", exact=True)
    kind.select_option("Ground reaction force")
    page.get_by_label("Axis").select_option("Z")
    expect(page.locator(".code-line code")).to_contain_text("//frame[mo:force('1', 'z') > ")
    expect(page.locator(".graph-plot")).to_be_visible()
    kind.select_option("Model output")
    expect(page.get_by_label("Measurement name")).to_have_value("LKneeAngles")
    expect(page.locator(".code-line code")).to_contain_text("//frame[mo:quantity('LKneeAngles', 'z') > ")
    kind.select_option("Analog channel")
    page.get_by_label("Measurement name").select_option("EMG")
    expect(page.get_by_label("Axis")).to_have_count(0)
    expect(page.locator(".code-line code")).to_contain_text("//frame[mo:analog('EMG') > ")


@one_door
def test_what_others_saved_is_told_without_requests(visit: Visit, studio: Served) -> None:
    visit.wanted = {412}
    uuid = studio.upload("kick.bvh", walk(30), unit="cm")
    page = visit.open(f"/clips/{uuid}?tab=info")
    ready(page)
    page.route("**/api/v1/events*", lambda one: one.abort())
    with studio.client() as client:
        client.patch(f"/documents/{uuid}", json={"description": "x"}, headers={"if-match": "*"}).raise_for_status()
    page.get_by_label("Description").fill("mine")
    page.get_by_label("Description").press("Tab")
    told = page.get_by_role("alert")
    expect(told).to_contain_text("Someone else changed this in the meantime.")
    expect(told).not_to_contain_text("request")
