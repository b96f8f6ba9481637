"""The gait of a clip in the studio: parameters, events, and labels that are made of them."""

from __future__ import annotations

from typing import Any

import pytest

from tests.builders import bvh
from tests.laboratory.gait_files import LENGTHS, WALKING, gait_file, stand, walk
from tests.laboratory.walkers import Gait, make_c3d
from tests.web.conftest import Served, Visit, one_door
from tests.web.test_journeys import ready
from tests.web.test_pages import faults

expect: Any = pytest.importorskip("playwright.sync_api").expect

GAIT = Gait(seconds=5, heading=-40)


@pytest.mark.slow
@one_door
def test_events_of_positions_become_labels_with_undo(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("walk.c3d", make_c3d(GAIT, []))
    page = visit.open(f"/clips/{uuid}?tab=gait")
    ready(page)
    panel = page.get_by_role("tabpanel")
    expect(panel.get_by_text("Walking")).to_be_visible()
    speed = panel.get_by_role("row").filter(has_text="Speed")
    expect(speed).to_contain_text("1.2")
    panel.get_by_role("button", name="Foot strike").first.click()
    expect(page.get_by_label("Frame", exact=True)).not_to_have_value("1")
    labels = page.locator(".span-item:has(.span:not(.offer))")  # not the suggested ones
    expect(labels).to_have_count(0)
    panel.get_by_role("button", name="Add events as labels").click()
    expect(labels.first).to_be_visible()
    expect(labels.filter(has_text="left-foot-strike").first).to_be_visible()
    page.get_by_role("button", name="Undo").first.click()
    expect(labels).to_have_count(0)


@one_door
def test_a_clip_is_compared_with_a_collection(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("walk.c3d", make_c3d(GAIT, []))
    other = studio.upload("other.c3d", make_c3d(Gait(seconds=5, speed=1.6), []))
    with studio.client() as client:
        client.put("/collections/healthy", json={"documents": [other]}).raise_for_status()
    page = visit.open(f"/clips/{uuid}?tab=gait")
    ready(page)
    panel = page.get_by_role("tabpanel")
    speed = panel.get_by_role("row").filter(has_text="Speed")
    expect(speed.get_by_role("cell")).to_have_count(4)
    panel.get_by_label("Normal band").select_option(label="default/healthy")
    expect(speed.get_by_role("cell")).to_have_count(6)
    expect(speed.get_by_role("cell").nth(4)).to_contain_text("1.6")
    panel.get_by_label("Normal band").select_option(label="None")
    expect(speed.get_by_role("cell")).to_have_count(4)
    with page.expect_download() as download:
        panel.get_by_role("link", name="Save numbers (CSV)").click()
    assert download.value.suggested_filename == "walk-gait.csv"


@one_door
def test_a_clip_without_feet_says_why_it_has_no_gait(visit: Visit, studio: Served) -> None:
    visit.wanted = {422}
    uuid = studio.upload("chain.bvh", bvh(20))
    page = visit.open(f"/clips/{uuid}?tab=gait")
    ready(page)
    expect(page.get_by_role("alert").first).to_be_visible()


@one_door
def test_a_walking_trial_takes_the_measures_of_a_standing_one(visit: Visit, studio: Served) -> None:
    visit.wanted = {422}  # of the gait of a body that stands
    studio.upload("static.c3d", gait_file(stand(), LENGTHS))
    uuid = studio.upload("walk.c3d", gait_file(walk(poses=WALKING), LENGTHS))
    page = visit.open(f"/clips/{uuid}?tab=gait")
    ready(page)
    panel = page.get_by_role("tabpanel")
    expect(panel.get_by_text("Standing trial: none")).to_be_visible()
    panel.get_by_role("button", name="Choose trial").click()
    page.get_by_role("dialog").get_by_role("button", name="static").click()
    dialog = page.get_by_role("dialog", name="Standing trial: static")
    turned = dialog.get_by_role("row").filter(has_text="ThighRotation")
    expect(turned).to_contain_text("6.88°-4.01°medial knee marker")
    assert faults(page) == []
    dialog.get_by_label("Foot").select_option(label="flat")
    expect(dialog.get_by_text("heel set to the height of the toe")).to_be_visible()
    dialog.get_by_role("button", name="Use for 1 trial").click()
    expect(panel.get_by_text("Standing trial: static")).to_be_visible()
    page.get_by_role("button", name="Undo").first.click()
    expect(panel.get_by_text("Standing trial: none")).to_be_visible()


@one_door
def test_a_standing_trial_is_given_to_chosen_walking_trials(visit: Visit, studio: Served) -> None:
    visit.wanted = {422}
    standing = studio.upload("static.c3d", gait_file(stand(), LENGTHS))
    uuid = studio.upload("walk.c3d", gait_file(walk(poses=WALKING), LENGTHS))
    page = visit.open(f"/clips/{standing}?tab=gait")
    ready(page)
    page.get_by_role("button", name="Use as standing trial").click()
    dialog = page.get_by_role("dialog", name="Standing trial: static")
    expect(dialog.get_by_role("button", name="Use for 0 trials")).to_be_disabled()
    dialog.get_by_role("button", name="Choose walking trials").click()
    chooser = page.get_by_role("dialog", name="Choose walking trials")
    chooser.get_by_role("button", name="walk").click()
    chooser.get_by_role("button", name="Close").click()
    dialog.get_by_role("button", name="Use for 1 trial").click()
    expect(page.get_by_text("Standing trial used for 1 trial")).to_be_visible()
    facts = studio.get(f"/documents/{uuid}")
    assert {"gait standing trial", "gait LThighRotation"} <= {item["name"] for item in facts["properties"]}
