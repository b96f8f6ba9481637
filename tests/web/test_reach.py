"""Reach synthesis in the browser: fitted, corrected and fitted again, slid by keys, saved; on generated and real
reaches."""

from __future__ import annotations

import io
import json
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_schemas.analyses.reach import ReachParameters
from mcml_service.actions.analysing.save_results import add_parts
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.actions.importing.load_demo import REACHES, add_clips
from mcml_service.analysis.interface import Motion, silent
from mcml_service.analysis.reach_blending.analyses import REACH
from mcml_service.demo.reach_clips import reach_clips
from mcml_service.settings import Settings
from tests.analysis.reach.hdm05 import TARGETS
from tests.analysis.reach.reach_motions import motion_of
from tests.web.conftest import Served

pytestmark = pytest.mark.usefixtures("lent_workers")

FEW = (3, 3, 3, 3)
FITTED = 60_000  # ms; the first job waits for its worker
MADE = re.compile(r"/reach/(?P<id>[0-9a-f-]{36})")
POSITIONS = """() => {
  const { preview } = mcmlReach.shown.value;
  return [preview.frames, Array.from(preview.frame(0)), Array.from(preview.frame(preview.frames - 1))];
}"""


@pytest.fixture
def reaches(open_studio: Served) -> Served:
    """A server with 24 reaches of eight people, in the demo's project."""
    store_reaches(open_studio)
    return open_studio


def store_reaches(served: Served) -> list[Motion]:
    """Reaches of eight people, three each; told as analyses get them."""
    made = reach_clips(young=FEW, old=FEW)
    add_clips(served.database, Settings(), REACHES, [one.clip for one in made], (), "")
    ids = {one["name"]: one["id"] for one in served.get("/documents", project=REACHES, limit=200)["items"]}
    return [replace(motion_of(one), document=ids[one.name]) for one in made]


def keep_model(served: Served) -> str:
    """A model of stored reaches, as a job would have kept it."""
    parameters = ReachParameters()
    parts = REACH.run(store_reaches(served), parameters, silent)
    with served.database.write("kim") as tx:
        project = tx.projects.get_or_add(REACHES)
        key, uuid = tx.results.add(project, "reach", "belt reach", "kim", [], parameters.model_dump(mode="json"), {})
        add_parts(tx, key, parts, {})
    return uuid


def fitted(served: Served, **parameters: Any) -> str:
    """A model of all reaches, by the API."""
    with served.client() as client:
        job = client.post("/analyses/reach", json={"inputs": {"project": REACHES}, "parameters": parameters}).json()
        with client.stream("GET", f"/jobs/{job['id']}/events") as events:
            assert events.read()
        done = client.get(f"/jobs/{job['id']}").json()
    assert done["state"] == "done", done.get("problem")
    return str(done["result"])


ARROW = """() => {
  const box = mcmlReachStage.canvas.getBoundingClientRect();
  for (let y = 2; y < box.height; y += 4)
    for (let x = 2; x < box.width; x += 4)
      if (mcmlReachStage.arrowAt(x, y) === "Y") return [box.x + x, box.y + y];
  return null;
}"""
"""A place in the page on the arrow along Y."""


def moved(page: Any) -> None:
    """Until the newest motion is there for the values that the sliders show."""
    page.wait_for_function(
        """() => window.mcmlReach?.shown.value &&
          JSON.stringify(mcmlReach.values.value) === JSON.stringify(mcmlReach.shown.value.answer.attributes)"""
    )


def made_by(served: Served, model: str, attributes: dict[str, float]) -> Any:
    """(frames, points, 3) that the API makes."""
    with served.client() as client:
        wish = {"parameters": {"attributes": attributes}}
        answer = client.post(f"/results/{model}/synthesize", params={"format": "npy"}, json=wish)
        return np.load(io.BytesIO(answer.content))


@pytest.mark.slow
def test_a_model_is_fitted_slid_and_saved(reaches: Served, visit_of: Any) -> None:
    page = visit_of(reaches).open("/reach")
    expect(page.get_by_role("button", name="Try it with demo clips")).to_be_visible()
    page.get_by_label("Project").select_option(REACHES)
    page.get_by_role("checkbox", name="reach_01_001").uncheck()
    page.get_by_role("button", name="Fit a model to 23 clips").click()
    page.wait_for_url(MADE, timeout=FITTED)
    model = MADE.search(page.url)["id"]  # type: ignore[index]
    assert len(reaches.get(f"/results/{model}")["inputs"]) == 23
    moved(page)
    expect(page.get_by_text("Inside the examples")).to_be_visible()
    frames, before, _ = page.evaluate(POSITIONS)

    age = page.get_by_role("slider", name="Age", exact=True)
    age.focus()
    for _ in range(4):
        page.keyboard.press("PageUp")
    page.keyboard.press("ArrowLeft")
    height = page.evaluate("() => mcmlReach.values.value.height") + 0.3
    page.get_by_label("Height, value").fill(f"{height:.1f}")
    page.keyboard.press("Enter")
    moved(page)
    expect(page.get_by_text("Between examples")).to_be_visible()
    expect(page.get_by_text("Age: no examples between")).to_be_visible()
    expect(page.get_by_text("no examples here").first).to_be_visible()
    values = page.evaluate("() => mcmlReach.values.value")
    frames, first, last = page.evaluate(POSITIONS)
    motion = made_by(reaches, model, values)
    assert values["height"] == pytest.approx(height)
    assert not np.allclose(before, first)
    assert len(motion) == frames
    for shown, row in ((first, motion[0]), (last, motion[-1])):
        points = np.reshape(shown, (-1, 3))[: len(row)]
        assert np.abs((points - points[0]) - (row - row[0])).max() < 1e-3

    page.wait_for_function("text => new URLSearchParams(location.search).get('height') === text", arg=f"{height:.1f}")
    page.reload()
    moved(page)
    assert page.evaluate("() => mcmlReach.values.value") == values
    page.get_by_role("button", name="Save as clip").click()
    page.get_by_role("dialog").get_by_label("Name").fill("reach at a gap")
    page.get_by_role("dialog").get_by_role("button", name="Save", exact=True).click()
    expect(page.get_by_text("reach at a gap saved")).to_be_visible()
    kept = reaches.get("/documents", q="reach at a gap")["items"][0]
    about = {one["name"]: one["value"] for one in reaches.get(f"/documents/{kept['id']}")["properties"]}
    assert (kept["frames"], float(about["height"])) == (frames, values["height"])
    assert json.loads(about["provenance"])["result"] == model
    page.get_by_role("button", name="Export").click()
    with page.expect_download() as download:
        page.get_by_role("menuitem", name="BVH").click()
    assert Path(download.value.path()).read_text().startswith("HIERARCHY")


@pytest.mark.slow
def test_the_motion_goes_on_in_the_same_phase_beside_the_nearest_example(open_studio: Served, visit_of: Any) -> None:
    reaches = open_studio
    page = visit_of(reaches).open(f"/reach/{keep_model(reaches)}?near=side")
    moved(page)
    page.get_by_role("button", name="Pause").click()
    page.evaluate("() => { const { player, shown } = mcmlReach; player.seek(shown.value.moments[1]); }")
    pad = page.get_by_role("slider", name="Age and Hip point")
    pad.focus()
    for key in ("PageUp", "ArrowRight", "ArrowRight"):
        pad.press(key)
    moved(page)
    at, moments = page.evaluate("() => [mcmlReach.player.at, mcmlReach.shown.value.moments]")
    assert at == pytest.approx(moments[1], abs=1e-6)
    # Home leads to the nearest example's own values.
    pad.press("Home")
    moved(page)
    values = page.evaluate("() => mcmlReach.values.value")
    source = page.evaluate("() => mcmlReach.shown.value.answer.skeleton_source.document")
    own = {one["name"]: one["value"] for one in reaches.get(f"/documents/{source}")["properties"]}
    assert values == {name: float(own[name]) for name in values}
    page.get_by_role("button", name="Ghost").click()
    expect(page.get_by_role("link", name="nearest:")).to_be_visible()


@pytest.mark.fuzz
def test_corrections_go_into_the_next_fit(open_studio: Served, visit_of: Any) -> None:
    reaches = open_studio
    model = keep_model(reaches)
    page = visit_of(reaches).open(f"/reach/{model}?tab=examples")
    row = page.get_by_role("row", name="reach_02_004")
    row.get_by_role("button", name="reach_02_004").click()
    edge = page.get_by_role("slider", name="t1: the reach begins")
    found = float(edge.get_attribute("aria-valuenow"))
    field = page.get_by_label("t1: the reach begins, frames")
    field.fill(str(found + 3))
    field.press("Enter")
    expect(page.get_by_role("tab", name="1 correction")).to_be_visible()
    edge.press("ArrowRight")
    expect(edge).to_have_attribute("aria-valuenow", f"{found + 3.5:g}")
    page.keyboard.press("Control+z")
    expect(edge).to_have_attribute("aria-valuenow", f"{found + 3:g}")
    page.get_by_role("checkbox", name="reach_01_001: include").uncheck()
    age = page.get_by_label("reach_03_007: Age")
    age.fill("29")
    age.press("Enter")
    expect(page.get_by_text("saved as 29")).to_be_visible()
    page.get_by_role("button", name="Fit again with 3 corrections").click()
    page.wait_for_url(lambda url: model not in url, timeout=FITTED)
    again = reaches.get(f"/results/{MADE.search(page.url)['id']}")  # type: ignore[index]
    assert len(again["inputs"]) == 23
    (times,) = again["parameters"]["times"].values()
    assert times["t1"] == pytest.approx(found + 3)
    names = [column["name"] for column in again["parts"]["clips"]["data"]["columns"]]
    rows = {row[2]: dict(zip(names, row, strict=True)) for row in again["parts"]["clips"]["data"]["rows"]}
    assert rows["reach_02_004"]["t1_frames"] == pytest.approx(found + 3)
    assert rows["reach_03_007"]["age"] == 29
    expect(row.get_by_text("set by hand")).to_be_visible()


@pytest.mark.slow
def test_a_table_of_values_is_pasted_and_taken_back(open_studio: Served, visit_of: Any) -> None:
    reaches = open_studio
    page = visit_of(reaches).open(f"/reach/{keep_model(reaches)}?tab=examples")
    page.get_by_role("button", name="Paste table").click()
    page.get_by_role("textbox", name="Paste table").fill("name\tage (year)\nreach_01_001\t28\nreach_01_002\t28\n")
    page.get_by_role("button", name="Apply values").click()
    expect(page.get_by_text("Values of 2 clips updated")).to_be_visible()
    expect(page.get_by_label("reach_01_002: Age")).to_have_value("28")
    page.get_by_role("button", name="Undo").first.click()
    expect(page.get_by_text("Values of 2 clips restored")).to_be_visible()
    one = reaches.get("/documents", q="reach_01_002")["items"][0]["id"]
    ages = {one["name"]: one["value"] for one in reaches.get(f"/documents/{one}")["properties"]}
    assert page.get_by_label("reach_01_002: Age").input_value() == ages["age"] != "28"


@pytest.mark.fuzz
def test_clips_that_an_error_names_are_left_out(reaches: Served, visit_of: Any) -> None:
    with reaches.client() as client:
        client.post("/properties", content="name,age (year)\nreach_01_001,270\n", headers={"content-type": "text/csv"})
    page = visit_of(reaches).open("/reach")
    page.get_by_label("Project").select_option(REACHES)
    page.get_by_role("button", name="Fit a model to 24 clips").click()
    expect(page.get_by_text("age is 270 in reach_01_001")).to_be_visible()
    page.get_by_role("button", name="Exclude this clip and fit").click()
    page.wait_for_url(MADE, timeout=FITTED)
    page.get_by_role("tab", name="Fit").click()
    expect(page.get_by_text("Fitted to 23 clips.")).to_be_visible()
    expect(page.get_by_role("img", name="Variance")).to_be_visible()
    page.get_by_role("button", name="hand", exact=True).click()
    expect(page.get_by_text("Distance of the hand")).to_be_visible()


@pytest.mark.slow
def test_real_reaches_are_blended_over_their_target(shared: Path, open_studio: Served, visit_of: Any) -> None:
    folder = shared / "asfamc" / "hdm05_reach"
    if not folder.is_dir():
        pytest.skip("the reach clips of HDM05 are not here")
    counts: Counter[str] = Counter()
    for file in sorted(folder.glob("*.amc")):
        match = re.match(r"HDM_(?P<who>..)_(?P<what>depositFloorR|grabHighR)_", file.name)
        if match is None or counts[match[0]] == 3:
            continue
        counts[match[0]] += 1
        properties = (("target", TARGETS[match["what"]], ""), ("subject", match["who"], ""))
        skeleton = folder / f"HDM_{match['who']}.asf"
        files = [SourceFile(path.name, io.BytesIO(path.read_bytes())) for path in (skeleton, file)]
        import_files(
            open_studio.database,
            files,
            ImportOptions(project=REACHES, properties=properties, frame_time=str(1 / 120)),
            Settings(),
        )
    model = fitted(open_studio, attributes=["target"])
    page = visit_of(open_studio).open(f"/reach/{model}?target=0.1")
    moved(page)
    expect(page.get_by_text("Between examples")).to_be_visible()
    slider = page.get_by_role("slider", name="target", exact=True)
    slider.focus()
    heights = []
    for _ in range(3):
        heights.append(np.reshape(page.evaluate(POSITIONS)[1:], (2, -1, 3))[:, :, 1].max())
        for _ in range(4):
            page.keyboard.press("PageUp")
        moved(page)
    assert len(set(heights)) == 3, "each place of the slider has a motion of its own"


@pytest.mark.slow
def test_the_hand_goes_to_a_target_and_misses_are_shown(open_studio: Served, visit_of: Any) -> None:
    reaches = open_studio
    visit = visit_of(reaches)
    visit.wanted.add(422)  # out of reach
    page = visit.open(f"/reach/{keep_model(reaches)}")
    moved(page)
    page.get_by_text("Hand target").click()
    field = page.get_by_label("Hand target Y (m)")
    before = float(field.input_value())
    field.fill(f"{before + 0.05:.3f}")
    field.press("Enter")
    expect(page.get_by_text("Hand 0 cm from the target")).to_be_visible()
    place = page.evaluate("() => mcmlReach.shown.value.answer.hand_place")
    assert place[1] == pytest.approx(before + 0.05, abs=0.002)
    page.wait_for_url(re.compile("target="))
    field.fill("5")
    field.press("Enter")
    status = page.get_by_role("status").filter(has_text="cm out of reach")
    expect(status).to_be_visible()
    page.get_by_role("button", name="Use nearest place").click()
    expect(status).to_have_count(0)
    expect(page.get_by_text("from the target")).to_be_visible()
    assert float(field.input_value()) < 5
    page.get_by_role("button", name="Remove target").click()
    assert page.evaluate("() => mcmlReach.wish().target") is None
    page.wait_for_function("() => mcmlReach.shown.value.answer.hand_error == null")
    # An arrow in the viewer drags the target along its axis; the field follows.
    page.evaluate("() => mcmlReach.player.pause()")  # while it plays the arrows go with the body
    before = [float(page.get_by_label(f"Hand target {axis} (m)").input_value()) for axis in "XYZ"]
    x, y = page.evaluate(ARROW)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 25, steps=4)
    page.mouse.up()
    page.wait_for_function("before => mcmlReach.target.value[1] < before", arg=before[1])
    after = [float(page.get_by_label(f"Hand target {axis} (m)").input_value()) for axis in "XYZ"]
    assert after[1] < before[1] - 0.02
    assert [after[0], after[2]] == [before[0], before[2]]
