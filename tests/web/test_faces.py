"""The expression space in the browser: walked from face to face, refined, played on the map and the face, exported."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from mcml_schemas.analyses.expression import ExpressionParameters
from mcml_service.actions.analysing.save_results import add_parts
from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.analysis.expression_space.analyses import EXPRESSION
from mcml_service.analysis.interface import Motion, silent
from mcml_service.demo.face_takes import EXPRESSIONS, face_takes
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.analysis.expression.face_motions import motions
from tests.analysis.expression.test_real_takes import read
from tests.web.conftest import Served


def keep_space(database: Database, given: Sequence[Motion]) -> str:
    """A space of takes, as a job would have kept it."""
    parts = EXPRESSION.run(given, ExpressionParameters(), silent)
    with database.write("kim") as tx:
        key, uuid = tx.results.add(tx.projects.get_or_add("faces"), "expression", "smiles", "kim", [], {}, {})
        add_parts(tx, key, parts, {})
    return uuid


@pytest.fixture(scope="module")
def small() -> list[Motion]:
    return motions(noise=0.1, gaps=0.01)


def faces(page: Any) -> Any:
    return page.get_by_role("list", name="expressions").get_by_role("button")


def walk_over_five(page: Any) -> None:
    """A path by clicking faces: the first, then linked ones that are not on it yet."""
    faces(page).first.click()
    for _ in range(4):
        on_it = page.locator(".faces-path .faces-keys button").count()
        page.locator(".faces-candidates .near").last.click()
        expect(page.locator(".faces-path .faces-keys button")).to_have_count(on_it + 1)


@pytest.mark.slow
def test_a_walk_over_five_faces_is_refined_played_and_exported(
    open_studio: Served, visit_of: Any, small: list[Motion]
) -> None:
    space = keep_space(open_studio.database, small)
    page = visit_of(open_studio).open(f"/faces/{space}?level=1")
    expect(page.get_by_text("22 expressions", exact=True)).to_be_visible()
    walk_over_five(page)
    page.wait_for_function("() => new URLSearchParams(location.search).get('keys')?.split(',').length === 5")
    page.reload()
    expect(page.locator(".faces-path .faces-keys button")).to_have_count(5)
    page.get_by_role("button", name="Create animation").click()
    page.wait_for_url(lambda url: space not in url)
    expect(page.get_by_role("heading", name="Version 1")).to_be_visible()
    kept = open_studio.get("/results", parent=space)["items"][0]
    path = open_studio.get(f"/results/{kept['id']}")["parts"]["path"]["data"]["path"]
    assert len(path["keys"]) == 5

    # The face that is drawn, and the cross, are those of the API's own motion.
    page.get_by_role("button", name="pause").click()
    slider = page.get_by_role("slider", name="frame")
    slider.press("Home")
    for _ in range(3):
        slider.press("PageDown")
    frame = int(slider.get_attribute("aria-valuenow")) - 1
    with open_studio.client() as client:
        wish = {"parameters": {"fps": 60, "most_samples": 36_000}}
        motion = np.load(io.BytesIO(client.post(f"/results/{kept['id']}/playback?format=npy", json=wish).content))
        samples = client.post(f"/results/{kept['id']}/playback", json=wish).json()["value"]["samples"]
    drawn = page.evaluate("window.mcmlFaces.face()")
    shown = np.array([np.nan if value is None else value for value in drawn]).reshape(-1, 3)
    expected = motion[frame]
    seen = ~np.isnan(shown[:, 0])
    assert seen.mean() > 0.9
    assert np.abs(shown[seen] - expected[seen]).max() < 1e-2
    points = open_studio.get(f"/results/{space}/map/coordinates")["values"]
    numbers = page.evaluate("window.mcmlFaces.cross()")
    both = [page.evaluate("([d, f]) => window.mcmlFaces.number(d, f)", [one["document"], one["frame"]])
            for one in (samples[frame]["frame_a"], samples[frame]["frame_b"])]  # fmt: skip
    share = samples[frame]["alpha"]
    for axis in range(2):
        mean = points[both[0]][axis] * (1 - share) + points[both[1]][axis] * share
        assert numbers[axis] == pytest.approx(mean, abs=0.1)

    page.get_by_role("button", name="Refine automatically").click()
    expect(page.get_by_role("heading", name="Version 2")).to_be_visible()
    finer = open_studio.get("/results", parent=kept["id"])["items"][0]
    page.get_by_role("link", name="Version 1").click()
    expect(page.get_by_role("heading", name="Version 1")).to_be_visible()
    page.get_by_role("link", name="Version 2").click()
    page.wait_for_url(f"**/{finer['id']}*")
    page.get_by_role("button", name="Export").click()
    with page.expect_download() as download:
        page.get_by_role("menuitem", name="TRC").click()
    assert Path(download.value.path()).read_text().startswith("PathFileType")
    page.get_by_role("button", name="Save as clip").click()
    page.get_by_role("button", name="Open").click()
    page.wait_for_url("**/clips/*")
    document = open_studio.get("/documents")["items"][0]
    assert document["name"].startswith("smiles")


@pytest.mark.fuzz
def test_what_is_not_linked_is_reached_by_a_route(open_studio: Served, visit_of: Any, small: list[Motion]) -> None:
    space = keep_space(open_studio.database, small)
    page = visit_of(open_studio).open(f"/faces/{space}?level=1")
    faces(page).first.click()
    page.locator(".faces-candidates button:not(.near)").last.click()
    expect(page.get_by_text("Not linked at this level.")).to_be_visible()
    between = int(page.locator(".banner p").inner_text().split()[1])
    page.get_by_role("button", name="Use this path").click()
    expect(page.locator(".faces-path .faces-keys button")).to_have_count(between + 2)
    page.get_by_role("button", name="Remove expression 2").click()
    expect(page.locator(".faces-path .faces-keys button")).to_have_count(1)
    # By keys alone: along a link, onto the path.
    chart = page.get_by_role("application")
    for key in ("ArrowRight", "ArrowLeft", "ArrowUp", "ArrowDown"):
        chart.press(key)
        chart.press("Enter")
    assert page.locator(".faces-path .faces-keys button").count() > 1
    chart.press("Backspace")
    # Another level has other faces: what is no face there is taken back, or taken up again.
    page.get_by_label("Level").press("ArrowRight")
    expect(page.get_by_text("44 expressions", exact=True)).to_be_visible()
    page.get_by_role("button", name="Markers").click()
    page.wait_for_url("**skin=markers*")


@pytest.mark.fuzz
def test_the_finest_level_has_all_frames(open_studio: Served, visit_of: Any, small: list[Motion]) -> None:
    """Its links are listed nowhere: they are asked for, face by face, and the way is the one that the refusal names."""
    space = keep_space(open_studio.database, small)
    count = len(open_studio.get(f"/results/{space}/map/take")["values"])
    level = open_studio.get(f"/results/{space}")["parts"]["space"]["data"]["summary"]["levels"] - 1
    visit = visit_of(open_studio)
    visit.wanted.add(422)
    page = visit.open(f"/faces/{space}?level={level}")
    expect(page.get_by_text(f"{count} expressions", exact=True)).to_be_visible()
    faces(page).first.click()
    page.locator(".faces-candidates .near").first.click()
    expect(page.locator(".faces-path .faces-keys button")).to_have_count(2)
    expect(page.locator(".faces-candidates .near").first).to_be_visible()
    page.locator(".faces-candidates button:not(.near)").last.click()
    page.get_by_role("button", name="Use this path").click()
    assert page.locator(".faces-path .faces-keys button").count() > 3


@pytest.mark.slow
def test_a_mesh_of_ones_own_follows_the_markers(
    open_studio: Served, visit_of: Any, small: list[Motion], tmp_path: Path
) -> None:
    space = keep_space(open_studio.database, small)
    mesh = tmp_path / "head.obj"
    corners = [(x, y, -(x * x + y * y) / 4) for y in (-1.0, 0.0, 1.0) for x in (-1.0, 0.0, 1.0)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    lines += [f"f {a} {a + 1} {a + 4} {a + 3}" for a in (1, 2, 4, 5)]
    mesh.write_text("\n".join(lines))
    visit = visit_of(open_studio)
    page = visit.open(f"/faces/{space}?level=1")
    expect(faces(page).first).to_be_visible()
    page.get_by_label("Open mesh").set_input_files(mesh)
    page.wait_for_url("**skin=mesh*")
    wrong = tmp_path / "notes.obj"
    wrong.write_text("nothing")
    page.get_by_label("Open mesh").set_input_files(wrong)
    expect(page.get_by_text("No mesh found in this file")).to_be_visible()


@pytest.mark.slow
@pytest.mark.usefixtures("lent_workers")
def test_a_map_is_built_from_takes(open_studio: Served, visit_of: Any) -> None:
    takes = [take.clip for take in face_takes(2, expressions=EXPRESSIONS[:2], every_marker=5, fps=20)]
    add_clips(open_studio.database, Settings(), "takes", takes, (), "")
    page = visit_of(open_studio).open("/faces?project=takes")
    page.get_by_role("button", name="Build map").click()
    page.wait_for_url("**/faces/*")
    expect(page.get_by_role("application")).to_be_visible()
    assert json.loads(json.dumps(open_studio.get("/results")["items"][0]["inputs"]))


@pytest.mark.slow
def test_real_takes_are_walked(open_studio: Served, visit_of: Any, shared: Path) -> None:
    folder = shared / "trc_facial"
    if not folder.is_dir():
        pytest.skip("the facial takes are not here")
    real = [read(path, 8) for path in sorted(folder.glob("*.trc"))]
    space = keep_space(open_studio.database, real)
    page = visit_of(open_studio).open(f"/faces/{space}?level=1")
    faces(page).first.click()
    page.locator(".faces-candidates .near").first.click()
    page.get_by_role("button", name="Create animation").click()
    expect(page.get_by_role("heading", name="Version 1")).to_be_visible()
    expect(page.get_by_role("slider", name="frame")).to_be_visible()
