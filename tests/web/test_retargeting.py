"""Retargeting: options, frames of the report, a mapping under a name, many clips at once."""

from __future__ import annotations

import re
from typing import Any

import pytest

from mcml.formats import FORMATS
from mcml_service.demo import body
from tests.builders import TRC
from tests.web.conftest import Served, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect


def person(name: str, height: float, motion: Any) -> bytes:
    return b"".join(FORMATS["bvh"].write(body.clip(name, height, *motion), "bvh"))


@pytest.mark.slow
def test_options_and_the_frames_of_the_report(open_studio: Served, visit_of: Any) -> None:
    walked = open_studio.upload("walk.bvh", person("walk", 170.0, body.walk(170.0, 1.5, 1.0, 6.0)))
    tall = open_studio.upload("tall.bvh", person("tall", 200.0, body.wave(200.0, 0.2, 1.5)))
    page = visit_of(open_studio).open(f"/retarget?from={walked}&to={tall}")
    page.get_by_text("Options").click()
    page.get_by_label("Match rest poses").check()
    # The report below is the one of this answer.
    with page.expect_response(
        lambda answer: "/retarget?" in answer.url and answer.request.post_data_json["travel_scale"] is not None
    ) as response:
        page.get_by_label("Travel scale").check()
    response.value.finished()
    asked = response.value.request.post_data_json
    assert asked["match_rest"] is True
    assert asked["travel_scale"] == pytest.approx(200 / 170, rel=0.01)
    page.wait_for_url(re.compile("rest=1.*travel=1"))
    worst = page.get_by_role("button", name=re.compile("^Largest error: frame"))
    number = int(worst.inner_text().split()[-1])
    worst.click()
    expect(page.get_by_role("slider", name="Frame")).to_have_attribute("aria-valuenow", str(number))
    contact = page.get_by_role("button", name=re.compile("contact in frames")).first
    first, last = map(int, re.findall(r"\d+", contact.inner_text()))
    contact.click()
    page.wait_for_url(re.compile(rf"f={first}(&|$)"))
    page.get_by_role("button", name="Pause").click()
    assert first <= int(page.get_by_role("slider", name="Frame").get_attribute("aria-valuenow")) <= last


@pytest.mark.slow
def test_a_mapping_gets_its_name_in_a_dialog(open_studio: Served, visit_of: Any) -> None:
    one, two = open_studio.upload("one.bvh", walk(40)), open_studio.upload("two.bvh", walk(1, seed=3))
    page = visit_of(open_studio).open(f"/retarget?from={one}&to={two}")
    expect(page.get_by_text("4 of 4 joints")).to_be_visible()
    page.get_by_role("button", name="Mapping").click()
    page.get_by_role("menuitem", name="Save mapping as").click()
    name = page.get_by_role("dialog").get_by_role("textbox", name="Name")
    expect(name).to_have_value("one to two")
    name.fill("legs")
    name.press("Enter")
    expect(page.get_by_text("Saved as legs")).to_be_visible()
    assert len(open_studio.get("/mappings")["items"][0]["pairs"]) == 4


@pytest.mark.fuzz
def test_many_clips_are_put_on_a_body_and_taken_back(open_studio: Served, visit_of: Any) -> None:
    for number in range(3):
        open_studio.upload(f"take_{number}.bvh", walk(20 + number), label="kick")
    markers = open_studio.upload("markers.trc", TRC)
    with open_studio.client() as client:
        labelled = client.post("/labels", json={"name": "kick", "xpath": "//frame", "document": [markers]})
        assert labelled.status_code == 200, labelled.text
    one, two = open_studio.upload("one.bvh", walk(40)), open_studio.upload("two.bvh", walk(1, seed=3))
    page = visit_of(open_studio).open(f"/retarget?from={one}&to={two}")
    page.get_by_role("button", name="Apply to many clips").click()
    dialog = page.get_by_role("dialog", name="Retarget clips to two")
    dialog.get_by_role("button", name="XPath").click()
    dialog.get_by_role("textbox", name="XPath").fill("//frame[motion_name='kick']")
    expect(dialog.get_by_role("status")).to_have_text("4 clips")
    dialog.get_by_role("button", name="Retarget clips").click()
    expect(dialog.get_by_role("status")).to_have_text("3 clips created. 1 failed.")
    rows = dialog.get_by_role("row")
    expect(rows).to_have_count(1 + 4)
    # Problems come first.
    expect(rows.nth(1)).to_contain_text("markers")
    with page.expect_download() as saved:
        dialog.get_by_role("button", name="Save table").click()
    lines = saved.value.path().read_text().splitlines()
    assert lines[0].startswith("name,source,document,limbs,hips")
    assert len(lines) == 5
    expect(rows.filter(has_text="markers")).to_contain_text("Choose a document of a body.")
    assert open_studio.get("/documents")["total"] == 6 + 3
    dialog.get_by_role("button", name="Undo").click()
    expect(page.get_by_text("3 clips deleted")).to_be_visible()
    assert open_studio.get("/documents")["total"] == 6


@pytest.mark.slow
def test_a_standard_rig_is_chosen_without_a_file(open_studio: Served, visit_of: Any) -> None:
    walked = open_studio.upload("walk.bvh", person("walk", 170.0, body.walk(170.0, 1.5, 1.0, 6.0)))
    page = visit_of(open_studio).open(f"/retarget?from={walked}")
    page.get_by_role("button", name=re.compile("Target character")).click()
    page.get_by_role("dialog").get_by_role("button", name="Unreal Engine 5 mannequin").click()
    page.wait_for_url(re.compile("rig=unreal5"))
    expect(page.get_by_text("of 80 joints")).to_be_visible()
    expect(page.get_by_label("index_02_l")).to_have_value("")
    page.get_by_label("left_hand").select_option("right_hand")
    page.get_by_role("button", name="Retarget", exact=True).click()
    page.wait_for_url(re.compile("/clips/"))
    made = open_studio.get(f"/documents/{page.url.split('/clips/')[1].split('?')[0]}")
    assert made["name"] == "walk on Unreal Engine 5 mannequin"
    assert {"pelvis", "index_02_l"} <= {bone["source_name"] for bone in made["bones"]}
