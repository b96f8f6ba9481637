"""A new file for an open clip: the difference is seen first, one revision replaces, undo takes it back."""

from __future__ import annotations

from typing import Any

import pytest

from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_dropping import drop
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = [one_door, pytest.mark.slow]


def last_frame(studio: Served, uuid: str) -> Any:
    return studio.get(f"/documents/{uuid}/frames", first=12, format="json")["items"][0]["values"]


def changed(content: bytes) -> bytes:
    """The same walk with another last row."""
    head, _, row = content.rstrip(b"\n").rpartition(b"\n")
    numbers = row.split()
    numbers[-1] = b"77"
    return head + b"\n" + b" ".join(numbers) + b"\n"


def test_a_chosen_file_replaces_what_differs(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("steps.bvh", walk(12))
    before = last_frame(studio, uuid)
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.get_by_role("toolbar", name="Play").get_by_role("button", name="Frames").click()
    with page.expect_file_chooser() as chooser:
        page.get_by_role("menuitem", name="Replace by a file").click()
    chooser.value.set_files([{"name": "again.bvh", "mimeType": "", "buffer": changed(walk(12))}])
    dialog = page.get_by_role("dialog", name="Replace by a file")
    expect(dialog.get_by_text("12–12")).to_be_visible()
    expect(dialog.get_by_text("→ 77")).to_be_visible()
    assert studio.get(f"/documents/{uuid}")["revision"] == 1
    dialog.get_by_role("button", name="Replace frames").click()
    expect(page.get_by_text("Motion replaced: 12 frames")).to_be_visible()
    assert studio.get(f"/documents/{uuid}")["revision"] == 2
    assert last_frame(studio, uuid) != before
    page.get_by_role("button", name="Undo").last.click()
    expect(page.get_by_text("revision 3")).to_be_visible()
    assert last_frame(studio, uuid) == before


def test_a_dropped_file_of_another_skeleton_is_refused(visit: Visit, studio: Served) -> None:
    visit.wanted = {409}
    uuid = studio.upload("steps.bvh", walk(12))
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    drop_onto(page, {"other.bvh": walk(12).replace(b"Hips", b"Pelvis")})
    dialog = page.get_by_role("dialog", name="Replace by a file")
    expect(dialog.get_by_text("has another name")).to_be_visible()
    expect(dialog.get_by_text("Import it as a document of its own, or replace the skeleton too")).to_be_visible()
    expect(dialog.get_by_role("button", name="Replace frames")).to_be_disabled()
    page.keyboard.press("Escape")
    drop_onto(page, {"same.bvh": walk(12)})
    expect(dialog.get_by_text("No frame differs.")).to_be_visible()


def test_the_skeleton_is_replaced_too_where_that_is_asked_for(visit: Visit, studio: Served) -> None:
    visit.wanted = {409}
    uuid = studio.upload("steps.bvh", walk(12))
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    drop_onto(page, {"other.bvh": walk(9).replace(b"Hips", b"Pelvis").replace(b"0.0333", b"0.0166")})
    dialog = page.get_by_role("dialog", name="Replace by a file")
    dialog.get_by_label("Replace the skeleton, unit and frame rate too").check()
    expect(dialog.get_by_text("12 → 9")).to_be_visible()
    expect(dialog.get_by_text("Joints removed")).to_be_visible()
    dialog.get_by_role("button", name="Replace frames").click()
    expect(page.get_by_text("Motion replaced: 9 frames")).to_be_visible()
    assert studio.get(f"/documents/{uuid}")["frames"] == 9
    page.get_by_role("button", name="Undo").last.click()
    expect(page.get_by_text("revision 3")).to_be_visible()
    assert studio.get(f"/documents/{uuid}")["frames"] == 12


def test_the_library_has_no_such_field(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("steps.bvh", walk(5))
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.goto(page.url.split("/clips/")[0] + "/library")
    expect(page.get_by_role("button", name="Import", exact=True)).to_be_visible()
    drop(page, {"one.bvh": walk(4)})
    expect(page.get_by_text("one.bvh").first).to_be_visible()
    expect(page.get_by_role("dialog")).to_have_count(0)


def drop_onto(page: Any, files: dict[str, bytes]) -> None:
    """Drop files on the field of the clip, which appears while they are over the window."""
    page.evaluate(
        """async files => {
          const data = new DataTransfer();
          for (const [name, bytes] of files) data.items.add(new File([new Uint8Array(bytes)], name));
          const send = (kind, at) =>
            at.dispatchEvent(new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true }));
          send("dragenter", document.body);
          const field = await new Promise(resolve => {
            const look = () => {
              const found = document.querySelector("[data-drop=onto]");
              if (found) resolve(found); else requestAnimationFrame(look);
            };
            look();
          });
          send("dragover", field);
          send("drop", field);
        }""",
        [[name, list(content)] for name, content in files.items()],
    )
