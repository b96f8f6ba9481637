"""The gait of a clip in the studio: parameters, events, and labels that are made of them."""

from __future__ import annotations

from typing import Any

import pytest

from tests.builders import bvh
from tests.laboratory.walkers import Gait, make_c3d
from tests.web.conftest import Served, Visit, one_door
from tests.web.test_journeys import ready

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
