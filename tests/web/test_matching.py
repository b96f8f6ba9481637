"""Motion matching in the studio: a body led by keys, by a drawn path and by a shape, stored as a clip."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from mcml.formats import FORMATS
from tests.builders import bvh
from tests.motion.matching.curved_walks import curved_walk
from tests.web.conftest import Served

expect: Any = pytest.importorskip("playwright.sync_api").expect
SECONDS = re.compile(r"(\d+\.\d) s, (\d+) cut")


@pytest.fixture
def walking(open_studio: Served, visit_of: Any) -> Any:
    """The page with clips that walk straight on and turn to both sides, and one of another body."""
    for turn in (0.0, 50.0, -50.0):
        content = b"".join(FORMATS["bvh"].write(curved_walk(turn), "bvh"))
        open_studio.upload(f"walk {turn:g}.bvh", content, project="walks", unit="cm")
    open_studio.upload("chain.bvh", bvh(30), project="walks")
    page = visit_of(open_studio).open("/motion-matching?project=walks")
    expect(page.get_by_role("status").filter(has_text="min of 3 clips")).to_be_visible()
    return page


def seconds(page: Any) -> float:
    match = SECONDS.search(page.get_by_role("status").filter(has_text="cut").inner_text())
    assert match is not None
    return float(match[1])


def await_seconds(page: Any, least: int) -> None:
    """Until the body has moved so many seconds."""
    expect(
        page.get_by_role("status").filter(has_text=re.compile(rf"({least}|{least + 1}|{least + 2})\.\d s"))
    ).to_be_visible()


def save(page: Any, name: str) -> None:
    page.get_by_role("button", name="Save as clip").click()
    dialog = page.get_by_role("dialog", name="New clip")
    dialog.get_by_label("Name").fill(name)
    dialog.get_by_role("button", name="Save").click()
    page.get_by_role("button", name="Open").click()
    page.wait_for_url(re.compile(r"/clips/"))


@pytest.mark.slow
def test_keys_lead_a_body_and_what_it_did_is_a_clip(open_studio: Served, walking: Any) -> None:
    page = walking
    page.get_by_text("1 clip left out").click()
    expect(page.get_by_text("it has another skeleton")).to_be_visible()
    page.get_by_role("heading", name="Motion matching").click()
    page.keyboard.down("w")
    await_seconds(page, 2)
    page.keyboard.up("w")
    page.get_by_role("button", name="Pause").click()
    lasted = seconds(page)
    save(page, "steered")
    uuid = page.url.split("/clips/")[1].split("?")[0]
    document = open_studio.get(f"/documents/{uuid}")
    assert document["name"] == "steered"
    assert document["project"] == "walks"
    assert document["frames"] / 60 == pytest.approx(lasted, abs=0.2)
    way = open_studio.get(f"/documents/{uuid}/frames", bone="Root", limit=1000)["items"]
    places = np.array([[row["values"]["Root"][axis] for axis in ("Tx", "Tz")] for row in way]) / 100
    # The walks go 1.3 m/s, and a hand that presses W leads on; the body turns to where the camera looks before.
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).sum() == pytest.approx(1.27 * lasted, rel=0.25)


@pytest.mark.slow
def test_a_shape_and_a_drawn_path_are_followed(walking: Any) -> None:
    page = walking
    page.get_by_role("button", name="Circle").click()
    expect(page.get_by_role("status").filter(has_text="m from the path")).to_be_visible()
    await_seconds(page, 1)
    ground = page.get_by_role("img", name="Map: drag to draw a path")
    box = ground.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for step in np.linspace(0, 40, 12):
        page.mouse.move(x + step, y - step)
    page.mouse.up()
    # A path of 2.5 m: its end comes in two or three seconds.
    expect(page.get_by_role("status").filter(has_text="End of the path reached")).to_be_visible()
    assert seconds(page) < 5
    expect(page.get_by_role("button", name="Play")).to_be_disabled()
    page.get_by_role("button", name="Start over").click()
    expect(page.get_by_role("status").filter(has_text="arrow keys")).to_be_visible()
    expect(page.get_by_role("button", name="Save as clip")).to_be_disabled()
