"""A clip changed in a real browser: tree, curves, text, names, sound; drafts, and windows that meet."""

from __future__ import annotations

import io
import re
import wave
from typing import Any

import pytest

from tests.web.conftest import Served, Visit, one_door, open_door, walk
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect


@pytest.mark.slow
@open_door
def test_a_value_is_changed_in_the_tree_seen_and_taken_back(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk())
    page = visit.open(f"/clips/{uuid}?f=5&sel=left_up_leg")
    ready(page)
    tree = page.get_by_role("tree", name="Tree")
    row = tree.get_by_role("treeitem").filter(has_text=re.compile(r"^Rx"))
    row.dblclick()
    field = tree.get_by_role("textbox", name="Rx")
    field.fill("77.5")
    before = page.locator(".stage").screenshot()
    field.press("Enter")
    expect(page.get_by_text("Draft: 1 change")).to_be_visible()
    expect(row).to_contain_text("77.5")
    expect_other_picture(page, before)
    page.keyboard.press("Control+s")
    expect(page.get_by_text("Saved as revision 2")).to_be_visible()
    value = "/mcml/motion/frame[5]/frame_bone[@name='left_up_leg']/@Rx"
    assert [float(item["value"]) for item in studio.get("/xpath", q=value, document=uuid)["items"]] == [77.5]
    page.get_by_role("status").get_by_role("button", name="Undo").click()
    expect(page.locator(".bar .chip").first).to_have_text("revision 3")
    assert [float(item["value"]) for item in studio.get("/xpath", q=value, document=uuid)["items"]] != [77.5]


def expect_other_picture(page: Any, before: bytes) -> None:
    for _ in range(100):
        if page.locator(".stage").screenshot() != before:
            return
        page.wait_for_timeout(50)
    raise AssertionError("the body did not move")


@pytest.mark.slow
@one_door
def test_a_curve_is_changed_and_undone_before_it_is_saved(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk())
    page = visit.open(f"/clips/{uuid}?f=5&sel=left_up_leg&tab=graph")
    ready(page)
    expect(page.locator(".uplot")).to_be_visible()
    field = page.get_by_role("group", name="Value at frame 5").get_by_label("Rx")
    expect(field).not_to_have_value("")
    old = field.input_value()
    field.fill("33.25")
    field.press("Enter")
    expect(page.get_by_text("Draft: 1 change")).to_be_visible()
    page.get_by_role("button", name="Offset", exact=True).last.click()
    expect(page.get_by_text("Draft: 2 changes")).to_be_visible()
    expect(field).to_have_value("38.25")
    page.get_by_role("button", name="Undo").click()
    expect(field).to_have_value("33.25")
    page.reload()
    ready(page)
    expect(page.get_by_text("Draft: 1 change")).to_be_visible(), "nothing is lost on reload"
    page.get_by_role("button", name="Discard").click()
    expect(field).to_have_value(old)


@one_door
def test_text_is_checked_where_it_is_wrong_and_saved_where_it_is_right(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk())
    page = visit.open(f"/clips/{uuid}?tab=text&f=3")
    ready(page)
    editor = page.get_by_role("textbox", name="MCML")
    expect(editor).to_contain_text("<frame")
    editor.click()
    page.keyboard.press("Control+Home")
    line = editor.locator(".cm-line").filter(has_text="left_up_leg").first
    line.click()
    page.keyboard.press("Home")
    page.keyboard.insert_text("<wrong/>")
    page.get_by_role("button", name="Validate").click()
    expect(page.get_by_role("status").filter(has_text="1 error")).to_be_visible()
    expect(page.locator(".cm-lint-marker-error")).to_be_visible()
    line.click()
    page.keyboard.press("Control+z")
    text = line.inner_text()
    page.keyboard.press("Home")
    page.keyboard.press("Shift+End")
    page.keyboard.insert_text(re.sub(r'Rx="[^"]*"', 'Rx="12.5"', text).strip())
    page.get_by_role("button", name="Apply", exact=True).click()
    expect(page.get_by_text("Draft: 1 change")).to_be_visible()
    page.get_by_role("button", name="Save", exact=True).click()
    expect(page.get_by_text("Saved as revision 2")).to_be_visible()
    found = studio.get("/xpath", q="//frame_bone[@name='left_up_leg'][@Rx='12.5']", document=uuid)
    assert len(found["items"]) == 1


@pytest.mark.slow
@one_door
def test_two_windows_meet_and_merge(visit: Visit, visit_of: Any, studio: Served) -> None:
    visit.wanted = {409, 412}
    uuid = studio.upload("kick.bvh", walk())
    page, other = (
        visit.open(f"/clips/{uuid}?f=5&sel=left_up_leg&tab=graph"),
        visit_of(studio).open(f"/clips/{uuid}?f=9&sel=Root&tab=graph"),
    )
    ready(page)
    ready(other)
    for window, frame, bone in ((page, 5, "Rx"), (other, 9, "Rx")):
        field = window.get_by_role("group", name=f"Value at frame {frame}").get_by_label(bone)
        expect(field).not_to_have_value("")
        field.fill("11.5")
        field.press("Enter")
    other.get_by_role("button", name="Save", exact=True).click()
    expect(other.get_by_text("Saved as revision 2")).to_be_visible()
    page.get_by_role("button", name="Save", exact=True).click()
    expect(page.get_by_text("Someone else saved this clip while you were editing.")).to_be_visible()
    page.get_by_role("button", name="Merge").click()
    expect(page.get_by_text("Saved as revision 3")).to_be_visible()
    for frame, bone in ((5, "left_up_leg"), (9, "Root")):
        value = f"/mcml/motion/frame[{frame}]/frame_bone[@name='{bone}']/@Rx"
        assert [float(item["value"]) for item in studio.get("/xpath", q=value, document=uuid)["items"]] == [11.5]


@one_door
@pytest.mark.fuzz
def test_a_draft_of_yesterday_meets_what_others_did(visit: Visit, studio: Served) -> None:
    visit.wanted = {409, 412}
    uuid = studio.upload("kick.bvh", walk())
    page = visit.open(f"/clips/{uuid}?f=5&sel=left_up_leg&tab=graph")
    ready(page)
    field = page.get_by_role("group", name="Value at frame 5").get_by_label("Rx")
    expect(field).not_to_have_value("")
    field.fill("11.5")
    field.press("Enter")
    expect(page.get_by_text("Draft: 1 change")).to_be_visible()
    page.goto("about:blank")
    with studio.client() as client:
        edit = {"frames": [{"first": 5, "columns": ["left_up_leg.Rx"], "values": [[3.25]]}]}
        answer = client.post(f"/documents/{uuid}/changes", json=edit, headers={"if-match": "1"})
        assert answer.status_code == 200, answer.text
    page = visit.open(f"/clips/{uuid}?f=5&sel=left_up_leg&tab=graph")
    ready(page)
    expect(page.get_by_text("Draft: 1 change")).to_be_visible()
    page.get_by_role("button", name="Save", exact=True).click()
    expect(page.get_by_text("Someone else saved this clip while you were editing.")).to_be_visible()
    value = "/mcml/motion/frame[5]/frame_bone[@name='left_up_leg']/@Rx"
    assert [item["value"] for item in studio.get("/xpath", q=value, document=uuid)["items"]] == ["3.25"], (
        "not written over"
    )
    page.get_by_role("button", name="Merge").click()
    expect(page.get_by_role("alert").get_by_role("row").last).to_contain_text("left_up_leg.Rx")
    expect(page.get_by_role("alert").get_by_role("row").last).to_contain_text("3.25")
    page.get_by_role("button", name="Keep mine").click()
    expect(page.locator(".bar .chip").first).to_have_text("revision 3")
    assert [item["value"] for item in studio.get("/xpath", q=value, document=uuid)["items"]] == ["11.5"]


@pytest.mark.slow
@one_door
def test_the_motion_follows_its_sound(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(600))
    page = visit.open(f"/clips/{uuid}?tab=video")
    ready(page)
    sound = io.BytesIO()
    with wave.open(sound, "wb") as file:
        file.setparams((1, 2, 8000, 0, "NONE", ""))
        file.writeframes(b"\0\0" * 8000 * 8)
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Choose video or sound").click()
    chooser.value.set_files({"name": "take.wav", "mimeType": "audio/wav", "buffer": sound.getvalue()})
    offset = page.get_by_label("Motion begins at")
    expect(offset).to_have_value("0")
    offset.fill("1.5")
    offset.press("Enter")
    # At rest it stands where the frame is.
    page.wait_for_function("""() => {
        const sound = document.querySelector("audio");
        return sound?.readyState >= 3 && Math.abs(sound.currentTime - 1.5) < 0.05;
    }""")
    page.get_by_role("button", name="Play", exact=True).click()
    page.wait_for_function("() => document.querySelector('audio').currentTime > 2.2")
    apart = page.evaluate("""() => {
        const frame = Number(document.querySelector('.frame-field').value) - 1;
        return document.querySelector('audio').currentTime - 1.5 - frame * 0.0083333;
    }""")
    assert abs(apart) < 0.1, "the picture follows the sound"
    page.get_by_role("button", name="Pause").click()
    assert page.evaluate("() => document.querySelector('audio').paused")
    page.get_by_role("button", name="Remove take.wav").click()
    expect(page.locator("audio")).to_have_count(0)


@one_door
def test_stretches_are_named_drawn_and_split(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(60))
    page = visit.open(f"/clips/{uuid}?f=20")
    ready(page)
    lane = page.get_by_role("list", name="labels")
    box = lane.bounding_box()
    page.mouse.move(box["x"] + box["width"] * 0.25, box["y"] + 10)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.7, box["y"] + 10, steps=5)
    page.mouse.up()
    page.get_by_role("combobox", name="Label").fill("stretch")
    page.keyboard.press("Enter")
    expect(lane.get_by_role("listitem")).to_have_count(1)
    page.keyboard.press("s")
    expect(lane.get_by_role("listitem")).to_have_count(2)
    page.keyboard.press("Control+s")
    expect(page.get_by_text("Saved as revision 2")).to_be_visible()
    labels = studio.get(f"/documents/{uuid}")["labels"]
    assert [(label["name"], label["first"], label["last"]) for label in labels] == [
        ("stretch", 16, 19),
        ("stretch", 20, 43),
    ]
