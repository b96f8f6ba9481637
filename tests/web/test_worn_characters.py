"""Characters of the library in the viewer and in exports: chosen beside *body*, drawn, kept, missed when they go."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mcml
from tests.formats.scenes.reading import read_glb
from tests.motion.bodies.made import person
from tests.web.conftest import Served, Visit, one_door
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect


def figure(folder: Path) -> bytes:
    """Our own figure as a file, as a character of its own."""
    source = folder / "person.bvh"
    source.write_bytes(person(2, 3))
    (path,) = mcml.convert(source, folder / "figure.glb", character="own")
    return path.read_bytes()


def choose(page: Any, name: str) -> None:
    page.locator(".body-choice").get_by_role("button").click()
    page.get_by_role("menuitemcheckbox", name=name).click()


@one_door
def test_a_character_of_the_library_is_chosen_drawn_and_exported(visit: Visit, studio: Served, tmp_path: Path) -> None:
    clip = studio.upload("dance.bvh", person(2, 60), unit="cm")
    content = figure(tmp_path)
    avatar = studio.upload("figure.glb", content)
    page = visit.open(f"/clips/{clip}?f=10")
    ready(page)
    with page.expect_response(lambda answer: f"character={avatar}" in answer.url and "space=rotations" in answer.url):
        choose(page, "figure")
    tools = page.locator(".viewer-tools")
    expect(tools.get_by_role("button", name="body", exact=True)).to_have_attribute("aria-pressed", "true")
    expect(page.locator(".body-name")).to_have_text("figure")
    assert wait_for_blue(page) > 2000, "the colours are those of the file"
    # The choice stays, on other pages too.
    page.reload()
    ready(page)
    expect(page.locator(".body-name")).to_have_text("figure")
    assert wait_for_blue(page) > 2000
    page.get_by_role("button", name="Export").click()
    page.get_by_role("menuitem", name="Export with options").click()
    dialog = page.get_by_role("dialog", name="Export with options")
    dialog.get_by_label("Program or format").select_option(label="glTF")
    dialog.get_by_label(re.compile("^Body")).select_option(label="figure")
    expect(dialog.get_by_text(f"--character {avatar}").first).to_be_visible()
    with page.expect_download() as saved:
        dialog.get_by_role("button", name="Export").click()
    path = tmp_path / saved.value.suggested_filename
    saved.value.save_as(path)
    vertices = [read_glb(each).body().shape[1] for each in (path.read_bytes(), content)]
    assert vertices[0] == vertices[1]


@one_door
def test_a_character_that_does_not_fit_says_why(visit: Visit, studio: Served, tmp_path: Path) -> None:
    clip = studio.upload("dance.bvh", person(2, 30), unit="cm")
    avatar = studio.upload("figure.glb", figure(tmp_path))
    page = visit.open(f"/clips/{clip}")
    ready(page)
    choose(page, "figure")
    expect(page.locator(".why-sticks")).to_have_count(0)
    visit.wanted.add(404)
    with studio.client() as client:
        client.delete(f"/documents/{avatar}", headers={"if-match": "*"})
    page.reload()
    ready(page)
    expect(page.locator(".body-name")).to_have_text("removed character")
    expect(page.locator(".why-sticks")).to_contain_text("No body.")
    choose(page, "own body")
    expect(page.locator(".why-sticks")).to_have_count(0)
    expect(page.locator(".body-name")).to_have_count(0)


def wait_for_blue(page: Any) -> int:
    """Pixels of the stage in the colour of the character, as soon as there are some."""
    from PIL import Image

    found = 0
    for _ in range(60):
        picture = Image.open(io.BytesIO(page.locator(".stage-canvas").screenshot())).convert("RGB")
        red, green, blue = np.moveaxis(np.asarray(picture, int), -1, 0)
        found = int(((blue > red + 25) & (blue > 90) & (green > red)).sum())
        if found > 2000:
            break
    return found
