"""Bodies with a skin in the studio: as Python moves them, drawn instead of bones, and why there is none."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcml.motion.bodies.clip_body import calibrate_clip
from mcml.motion.characters.figure import bind_character
from mcml.motion.kinematics import Walker
from mcml.motion.skeleton import Convention
from mcml.motion.units import reading_of
from mcml_service.actions.reading.describe_character import describe_mesh
from tests.motion.bodies.made import clip_of, person
from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_journeys import ready
from tests.web.test_units import vitest

expect: Any = pytest.importorskip("playwright.sync_api").expect


@pytest.mark.slow
def test_the_studio_moves_figures_as_python_does(tmp_path: Path) -> None:
    cases = []
    for seed, convention in enumerate((Convention.LISTED, Convention.FIXED, Convention.BASE)):
        clip = clip_of(person(seed, 30), convention)
        skeleton, reading = clip.head.skeleton, reading_of(clip.head)
        made = bind_character(skeleton, reading, calibrate_clip(clip, 30).start)
        (block,) = clip.blocks()
        positions, rotations = (each[::10] for each in Walker(skeleton, reading).poses(block))
        moved = made.move(positions, rotations)
        frames = [
            {"positions": at.ravel().tolist(), "turns": turn.ravel().tolist(), "expected": points.tolist()}
            for at, turn, points in zip(positions, rotations, moved, strict=True)
        ]
        mesh = describe_mesh(made).model_dump()
        size = float(np.ptp(made.points, axis=0).max())
        cases.append({"title": convention.value, "mesh": mesh, "frames": frames, "size": size})
    (tmp_path / "figures.json").write_text(json.dumps(cases))
    said = vitest("src/motion/body/skin.test.ts", MCML_FIGURES=tmp_path / "figures.json")
    print(said)
    assert f"{4 + len(cases)} passed" in said


def count_figure_pixels(page: Any) -> int:
    """Pixels of the viewer that are not of its ground."""
    from PIL import Image

    picture = Image.open(io.BytesIO(page.locator(".stage-canvas").screenshot())).convert("RGB")
    pixels = np.asarray(picture).astype(int)
    colours, counts = np.unique(pixels.reshape(-1, 3), axis=0, return_counts=True)
    ground = colours[np.argmax(counts)]
    return int((np.abs(pixels - ground).sum(axis=2) > 90).sum())


@pytest.mark.slow
@one_door
def test_a_body_is_drawn_instead_of_bones_and_stays_chosen(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("dance.bvh", person(2, 60), unit="cm")
    page = visit.open(f"/clips/{uuid}?f=10")
    ready(page)
    body = page.locator(".viewer-tools").get_by_role("button", name="body", exact=True)
    expect(body).to_have_attribute("aria-pressed", "false")
    bones = count_figure_pixels(page)
    assert bones > 500
    with page.expect_response(lambda answer: "space=rotations" in answer.url):
        body.click()
    expect(body).to_have_attribute("aria-pressed", "true")
    with_body = wait_until_larger(page, int(1.25 * bones))
    page.reload()
    ready(page)
    expect(body).to_have_attribute("aria-pressed", "true")
    assert wait_until_larger(page, int(1.25 * bones)) > 0.9 * with_body
    # Ghosts and trails are drawn with it, and bones are back by the key.
    page.get_by_role("button", name="ghosts", exact=True).click()
    page.get_by_role("button", name="trails", exact=True).click()
    assert wait_until_larger(page, with_body) > with_body
    page.locator(".stage").press("b")
    expect(body).to_have_attribute("aria-pressed", "false")


def wait_until_larger(page: Any, least: int) -> int:
    """Pixels of the body, as soon as there are so many."""
    for _ in range(100):
        found = count_figure_pixels(page)
        if found > least:
            return found
    raise AssertionError(f"{found} pixels are drawn, expected more than {least}")


@pytest.mark.slow
@one_door
def test_a_clip_without_the_joints_of_a_person_says_so(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("leg.bvh", walk(40), unit="cm")
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.locator(".viewer-tools").get_by_role("button", name="body", exact=True).click()
    said = page.locator(".why-sticks")
    expect(said).to_contain_text("No body.")
    expect(said).to_contain_text("A body needs joints that are not recognised: left_up_arm")
    assert count_figure_pixels(page) > 100
    page.locator(".viewer-tools").get_by_role("button", name="body", exact=True).click()
    expect(said).to_have_count(0)
