"""Stories of people in a real browser, from files to the file that they wanted, with clicks counted."""

from __future__ import annotations

import csv
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
from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.demo import body
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.demo.walks import turning_walk
from mcml_service.settings import Settings
from tests.laboratory.walkers import Gait, events_of, make_c3d
from tests.web.conftest import Served
from tests.web.test_dance import song
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


@pytest.mark.slow
def test_a_biomechanist_gets_a_gait_table_of_25_trials(
    open_studio: Served, visit_of: Any, shared: Path, tmp_path: Path
) -> None:
    """25 C3D files, five of them real trials of laboratories, as a gait table in CSV: at most 15 clicks."""
    real = [
        shared / "lab" / f"{name}.c3d" for name in ("bmc_gait", "ja1gait35", "s4_am_gait04", "hc030a05", "walking5")
    ]
    files = [str(path) for path in real]
    for number in range(20):
        gait = Gait(seconds=5, width=0.12 + 0.002 * number, speed=1.0 + 0.02 * number)
        path = tmp_path / f"trial{number:02}.c3d"
        path.write_bytes(make_c3d(gait, sorted(events_of(gait))))
        files.append(str(path))
    hand = Hand()
    page = visit_of(open_studio).open("/library")
    with page.expect_file_chooser() as chooser:
        hand.press(page.get_by_role("button", name="Import", exact=True))
    chooser.value.set_files(files)
    tray = page.get_by_role("region", name="Import")
    hand.press(tray.get_by_role("button", name="Select all 25 imported clips"), timeout=120_000)
    hand.press(page.get_by_role("toolbar", name="25 selected").get_by_role("button", name="Measure"))
    hand.press(page.get_by_role("button", name="Add gait angles"))
    hand.choose(page.get_by_role("combobox", name="Frame ranges"), "Strides of gait")
    save = page.get_by_role("button", name="Download CSV")
    expect(page.get_by_role("status").filter(has_text=re.compile(r"rows of \d+ clips"))).to_be_visible(timeout=120_000)
    expect(save).to_be_enabled()
    with page.expect_download() as saved:
        hand.press(save)
    with Path(saved.value.path()).open() as file:
        rows = list(csv.DictReader(file))
    measured = {row["name"] for row in rows}
    assert {f"trial{number:02}" for number in range(20)} <= measured
    assert measured & {path.stem for path in real}, "no real trial has strides"
    knee = [
        float(row["maximum"])
        for row in rows
        if row["quantity"] == "angle:left-knee-flexion" and row["name"] in {path.stem for path in real}
    ]
    assert 45 < np.median(knee) < 80  # People bend the knee by about 60 degrees in swing.
    assert len(hand.clicks) <= 15, hand.clicks


@pytest.mark.slow
@pytest.mark.usefixtures("lent_workers")
def test_a_dancer_gets_a_dance_to_a_song_and_takes_it_back(open_studio: Served, visit_of: Any) -> None:
    """Song, a dance to its beats, undo: at most 10 clicks."""
    pytest.importorskip("librosa", reason="the extra audio is not installed")
    clips = [dance_clip("groove", bars=8, seed=seed, name=f"groove {seed}").clip for seed in (1, 2, 3)]
    add_clips(open_studio.database, Settings(), "dances", clips, (), "")
    hand = Hand()
    page = visit_of(open_studio).open("/library")
    expect(page.get_by_role("gridcell")).to_have_count(3)
    press_keys(page, "g", "d")
    hand.choose(page.get_by_label("Project"), "dances")
    hand.press(page.get_by_role("button", name="Open clips"))
    expect(page.locator(".bench-row")).to_have_count(3, timeout=60_000)  # of an analysis
    with page.expect_file_chooser() as chooser:
        hand.press(page.locator("label.button").filter(has=page.get_by_label("Music", exact=True)))
    chooser.value.set_files({"name": "song.wav", "mimeType": "audio/wav", "buffer": song(120, 20)})
    expect(page.get_by_role("slider", name="Audio offset")).to_be_visible(timeout=120_000)
    hand.press(page.get_by_role("button", name="Create dance", exact=True))
    page.wait_for_url(re.compile(r"/dance/[0-9a-f-]{36}"), timeout=60_000)
    expect(page.get_by_role("button", name="Save…")).to_be_visible()
    result = page.url.split("/dance/")[1].split("?")[0]
    made = open_studio.get(f"/results/{result}")["parts"]["clip"]["document"]
    assert open_studio.get(f"/documents/{made}")["media"]["name"] == "song.wav"
    hand.press(page.get_by_role("button", name=re.compile("Play: Transition from bar")).first)
    page.wait_for_function("() => window.mcmlDance.frame() > 0")
    hand.press(page.get_by_role("button", name="Undo", exact=True).last)
    expect(page.get_by_text("dance deleted")).to_be_visible()
    assert made not in {one["id"] for one in open_studio.get("/documents")["items"]}
    assert len(hand.clicks) <= 10, hand.clicks
