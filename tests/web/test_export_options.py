"""Export with options in a real browser: the file has the height, the range and the place that were chosen."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mcml
from mcml.formats import FORMATS
from mcml_service.demo import body
from tests.formats.scenes.reading import read_glb
from tests.motion.solving.trials import pair, trial, with_gaps
from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_journeys import ready
from tests.web.test_pages import faults

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = one_door


@pytest.mark.slow
def test_a_loop_is_exported_tall_and_in_place(visit: Visit, studio: Served, tmp_path: Path) -> None:
    clip = body.clip("walk", 170.0, *body.walk(170.0, 4.0, 1.0, 6.0))
    uuid = studio.upload("steps.bvh", b"".join(FORMATS["bvh"].write(clip, "bvh")), unit="cm", up="Y")
    page = visit.open(f"/clips/{uuid}?in=41&out=100")
    ready(page)
    page.get_by_role("button", name="Export").click()
    page.get_by_role("menuitem", name="Export with options").click()
    dialog = page.get_by_role("dialog", name="Export with options")
    known = studio.get(f"/documents/{uuid}/calibration")["height"]["metres"]
    expect(dialog.get_by_role("img", name=f"Standing height in the file: {known:.2f} m")).to_be_visible()
    dialog.get_by_label("Program or format").select_option(label="For MotionBuilder")
    height = dialog.get_by_label("Standing height (m)")
    height.fill("1.75")
    height.blur()
    expect(dialog.get_by_role("img", name="Standing height in the file: 175 cm")).to_be_visible()
    dialog.get_by_label("In place, without travel over the ground").check()
    expect(dialog.get_by_label("Only frames 41–100")).to_be_checked()
    expect(dialog.get_by_text("--for motionbuilder --height 1.75 --in-place --first 41 --last 100")).to_be_visible()
    with page.expect_download() as saved:
        dialog.get_by_role("button", name="Export").click()
    expect(dialog.get_by_text("Saved steps.bvh")).to_be_visible()
    expect(dialog.get_by_role("listitem").filter(has_text="for 1.75 m")).to_be_visible()
    path = tmp_path / saved.value.suggested_filename
    saved.value.save_as(path)
    motion = mcml.read(path)
    assert len(motion.position("Root", "x")) == 60
    assert np.ptp(motion.position("Root", "x")) < 0.01
    height.fill("")
    height.blur()
    expect(dialog.get_by_text("--height")).to_have_count(0)


def test_a_clip_is_exported_with_a_body(visit: Visit, studio: Served, tmp_path: Path) -> None:
    clip = body.clip("walk", 170.0, *body.walk(170.0, 1.0, 1.0, 6.0))
    uuid = studio.upload("steps.bvh", b"".join(FORMATS["bvh"].write(clip, "bvh")), unit="cm", up="Y")
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.get_by_role("button", name="Export").click()
    page.get_by_role("menuitem", name="Export with options").click()
    dialog = page.get_by_role("dialog", name="Export with options")
    with_body = dialog.get_by_label(re.compile("^Body"))
    dialog.get_by_label("Program or format").select_option(label="For MotionBuilder")
    expect(with_body).to_have_count(0)
    dialog.get_by_label("Program or format").select_option(label="For Blender")
    with_body.select_option(label="own body")
    expect(dialog.get_by_text("--for blender --character own")).to_be_visible()
    with page.expect_download() as saved:
        dialog.get_by_role("button", name="Export").click()
    expect(dialog.get_by_text("Saved steps.glb")).to_be_visible()
    path = tmp_path / saved.value.suggested_filename
    saved.value.save_as(path)
    scene = read_glb(path.read_bytes())
    assert len(scene.body()[0]) > 1500
    known = studio.get(f"/documents/{uuid}/calibration")["height"]["metres"]
    assert abs(np.ptp(scene.body()[0][:, 1]) - known) < 0.05 * known


def test_the_loop_is_recorded_as_a_video(visit: Visit, studio: Served, tmp_path: Path) -> None:
    uuid = studio.upload("walk.bvh", walk(40))
    page = visit.open(f"/clips/{uuid}?in=11&out=20")
    ready(page)
    page.get_by_role("button", name="Save image").click()
    with page.expect_download() as saved:
        page.get_by_role("menuitem", name="Record video").click()
    path = tmp_path / saved.value.suggested_filename
    saved.value.save_as(path)
    head = path.read_bytes()[:12]
    assert head[4:8] == b"ftyp" if path.suffix == ".mp4" else head.startswith(b"\x1a\x45\xdf\xa3")


@pytest.mark.slow
def test_markers_of_two_people_become_two_skeletons(visit: Visit, studio: Served) -> None:
    content = b"".join(FORMATS["trc"].write(with_gaps(trial(pair())), "trc"))
    uuid = studio.upload("match.trc", content)
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.get_by_role("button", name="Export").click()
    expect(page.get_by_role("menuitem", name="BVH")).to_be_disabled()
    page.get_by_role("menuitem", name="Make skeleton").click()
    dialog = page.get_by_role("dialog", name="Make skeleton")
    dialog.get_by_label("Anna").uncheck()
    dialog.get_by_text("21 joints").last.click()
    expect(dialog.get_by_role("cell", name="left_up_leg")).to_be_visible()
    dialog.get_by_role("button", name="Make skeleton").click()
    expect(page.get_by_role("heading", name="match Bea")).to_be_visible()
    ready(page)
    assert "/clips/" in page.url
    assert uuid not in page.url


@pytest.mark.slow
def test_several_clips_are_exported_with_options(visit: Visit, studio: Served, tmp_path: Path) -> None:
    for name, height in (("short.bvh", 150.0), ("tall.bvh", 190.0)):
        clip = body.clip("walk", height, *body.walk(height, 1.0, 1.0, 6.0))
        studio.upload(name, b"".join(FORMATS["bvh"].write(clip, "bvh")), unit="cm", up="Y")
    studio.upload("unknown.bvh", walk(5))
    page = visit.open("/library?sort=name")
    expect(page.get_by_role("gridcell")).to_have_count(3)
    page.get_by_role("gridcell").nth(0).click(modifiers=["Control"])
    page.get_by_role("gridcell").nth(2).click(modifiers=["Shift"])
    page.get_by_role("toolbar", name="3 selected").get_by_role("button", name="Export").click()
    page.get_by_role("menuitem", name="Export with options").click()
    dialog = page.get_by_role("dialog", name="Export with options")
    expect(dialog.get_by_text("3 clips in a zip.")).to_be_visible()
    assert faults(page) == []
    dialog.get_by_label("Program or format").select_option(label="For MotionBuilder")
    dialog.get_by_label("Standing height (m)").fill("1.75")
    dialog.get_by_label("Standing height (m)").blur()
    expect(
        dialog.get_by_text(re.compile(r"^mcml export \S+ \S+ \S+ --for motionbuilder --height 1.75"))
    ).to_be_visible()
    with page.expect_download() as saved:
        dialog.get_by_role("button", name="Export").click()
    expect(dialog).to_have_count(0)
    saved.value.save_as(tmp_path / "clips.zip")
    with zipfile.ZipFile(tmp_path / "clips.zip") as archive:
        assert sorted(archive.namelist()) == ["refused.txt", "short.bvh", "tall.bvh"]
        archive.extractall(tmp_path)
    short, tall = (mcml.read(tmp_path / name).position("Head", "y") for name in ("short.bvh", "tall.bvh"))
    assert np.median(short) == pytest.approx(np.median(tall), rel=0.02)
