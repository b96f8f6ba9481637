"""Stories of people in a real browser, from files to the file that they wanted, with clicks counted."""

from __future__ import annotations

import json
import re
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mcml
from mcml.formats import FORMATS
from mcml_service.demo import body
from mcml_service.demo.walks import turning_walk
from tests.web.conftest import Served
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect

MANNEQUIN = {
    "Hips": "pelvis", "Spine": "spine_01", "Spine1": "spine_03", "Neck": "neck_01", "Head": "head",
    **{
        name.replace("*", side): f"{bone}_{side[0].lower()}"
        for side in ("Left", "Right")
        for name, bone in (
            ("*Shoulder", "clavicle"), ("*Arm", "upperarm"), ("*ForeArm", "lowerarm"), ("*Hand", "hand"),
            ("*UpLeg", "thigh"), ("*Leg", "calf"), ("*Foot", "foot"), ("*ToeBase", "ball"),
        )
    },
}  # fmt: skip
"""Joints of the generated body as the mannequin of Unreal Engine calls them."""


class Hand:
    """Clicks on a page, counted."""

    def __init__(self) -> None:
        self.clicks: list[str] = []

    def press(self, what: Any, **options: Any) -> None:
        self.clicks.append(str(what))
        what.click(**options)

    def choose(self, what: Any, label: str | re.Pattern[str]) -> None:
        """Open a list and choose one of its items."""
        self.clicks += [f"open {what}", f"choose {label}"]
        what.select_option(label=label)


def press_keys(page: Any, *keys: str) -> None:
    """Keys of the page, outside any field."""
    page.locator("body").press("Escape")
    for key in keys:
        page.keyboard.press(key)


def archive(folder: Path) -> Path:
    """A zip of three walks, of which two turn right, and of a mannequin."""
    path = folder / "walks.zip"
    with zipfile.ZipFile(path, "w") as file:
        for name, turn in (("ahead", 0.0), ("curve", -50.0), ("round", -90.0)):
            clip = turning_walk(name, 174.0, turn, 4.0)
            file.writestr(f"{name}.bvh", b"".join(FORMATS["bvh"].write(clip, "bvh")))
        clip = body.clip("mannequin", 180.0, *body.walk(180.0, 0.5, 1.0, 0.0))
        text = b"".join(FORMATS["bvh"].write(clip, "bvh")).decode()
        for name, bone in MANNEQUIN.items():
            text = re.sub(rf"\b(ROOT|JOINT) {name}\b", rf"\1 {bone}", text)
        file.writestr("mannequin.bvh", text)
    return path


def scene_of(path: Path) -> dict[str, Any]:
    """The JSON of a binary glTF file."""
    content = path.read_bytes()
    (length,) = struct.unpack_from("<I", content, 12)
    found: dict[str, Any] = json.loads(content[20 : 20 + length])
    return found


@pytest.mark.slow
def test_an_animator_loops_a_turn_on_a_mannequin(open_studio: Served, visit_of: Any, tmp_path: Path) -> None:
    """Zip, all right turns, one as a loop, on the mannequin, exported at 1.75 m: at most 18 clicks."""
    hand = Hand()
    page = visit_of(open_studio).open("/library?sort=name")
    with page.expect_file_chooser() as chooser:
        hand.press(page.locator(".toolbar .primary"))
    chooser.value.set_files(archive(tmp_path))
    expect(page.get_by_role("gridcell")).to_have_count(4)
    hand.press(page.locator(".tray header").get_by_role("button").last)
    press_keys(page, "g", "x")
    editor = page.get_by_role("textbox", name="XPath")
    editor.fill("//frame[mo:activity('turn right')]")
    page.keyboard.press("Control+Enter")
    expect(page.get_by_role("status").filter(has_text="480 frames in 2 ranges")).to_be_visible()
    page.keyboard.press("Escape")
    hand.press(page.get_by_role("option", name="curve"))
    hand.press(page.get_by_role("link", name="Open"))
    ready(page)
    hand.press(page.get_by_role("toolbar", name="Play").get_by_role("button", name="Frames"))
    hand.press(page.get_by_role("menuitem", name="Make a loop"))
    hand.press(page.get_by_role("dialog").get_by_role("button", name="Save as clip"))
    hand.press(page.get_by_role("button", name="Open", exact=True))
    expect(page.get_by_text("curve loop", exact=True).first).to_be_visible()
    ready(page)
    hand.press(page.get_by_role("button", name="Export"))
    hand.press(page.get_by_role("menuitem", name="Retarget"))
    hand.press(page.get_by_role("button", name=re.compile("^Target character")))
    hand.press(page.get_by_role("dialog").get_by_role("button", name="mannequin"))
    hand.press(page.get_by_role("button", name="Retarget", exact=True))
    page.wait_for_url(re.compile("/clips/"))
    ready(page)
    hand.press(page.get_by_role("button", name="Export"))
    hand.press(page.get_by_role("menuitem", name="Export with options"))
    dialog = page.get_by_role("dialog", name="Export with options")
    hand.choose(dialog.get_by_label("Program or format"), "For Unreal Engine")
    height = dialog.get_by_label("Standing height (m)")
    height.fill("1.75")
    height.blur()
    with page.expect_download() as saved:
        hand.press(dialog.get_by_role("button", name="Export"))
    expect(dialog.get_by_text("for 1.75 m")).to_be_visible()
    path = tmp_path / saved.value.suggested_filename
    saved.value.save_as(path)
    nodes = {node.get("name") for node in scene_of(path)["nodes"]}
    assert {"pelvis", "thigh_l", "upperarm_r"} <= nodes
    motion = mcml.read(path)
    assert motion._body.calibration.metres == 1.0
    assert len(hand.clicks) <= 18, hand.clicks


@pytest.mark.slow
def test_an_engineer_gets_an_array_of_a_query(open_studio: Served, visit_of: Any, tmp_path: Path) -> None:
    """Files, a query, npz: at most 6 clicks after the files are there."""
    for name, turn in (("ahead", 0.0), ("curve", -50.0)):
        clip = turning_walk(name, 174.0, turn, 4.0)
        open_studio.upload(f"{name}.bvh", b"".join(FORMATS["bvh"].write(clip, "bvh")))
    hand = Hand()
    page = visit_of(open_studio).open("/library")
    expect(page.get_by_role("gridcell")).to_have_count(2)
    press_keys(page, "g", "x")
    page.get_by_role("textbox", name="XPath").fill("//frame[mo:height('left_foot') > 0.2]")
    page.keyboard.press("Control+Enter")
    expect(page.get_by_role("status").filter(has_text="ranges")).to_be_visible()
    page.keyboard.press("Escape")
    hand.press(page.get_by_role("button", name="Export all"))
    hand.press(page.get_by_role("menuitem", name="Arrays …"))
    dialog = page.get_by_role("dialog", name="Export arrays")
    expect(dialog.get_by_label("In scripts", exact=True).last).to_contain_text("repo.arrays(")
    with page.expect_download() as saved:
        hand.press(dialog.get_by_role("button", name="Download arrays.npz"))
    path = tmp_path / saved.value.suggested_filename
    saved.value.save_as(path)
    with np.load(path) as arrays:
        assert arrays["values"].ndim == 3
        assert set(arrays["names"]) == {"ahead", "curve"}
    assert len(hand.clicks) <= 6, hand.clicks
