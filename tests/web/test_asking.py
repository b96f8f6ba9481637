"""The XPath console for those who do not know XPath: choices, examples, lines for scripts."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.web.conftest import Served, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect


def test_a_question_is_built_by_keys_alone_and_folds_when_it_is_written_by_hand(
    open_studio: Served, visit_of: Any
) -> None:
    open_studio.upload("kick.bvh", walk(), label="left-leg-flexion:10-25")
    page = visit_of(open_studio).open("/xpath")
    editor = page.get_by_role("textbox", name="XPath")
    expect(editor).to_be_focused()
    builder = page.get_by_role("form", name="Builder")
    builder.get_by_role("button", name="Motion name").press("Enter")
    expect(editor).to_have_text("//frame[motion_name = 'left-leg-flexion']")
    expect(builder.get_by_label("Motion name", exact=True).locator("option:checked")).to_have_text(
        "left-leg-flexion (1 clip)"
    )
    builder.get_by_role("button", name="Place in the clip").press("Enter")
    builder.get_by_label("from", exact=True).fill("20")
    builder.get_by_label("from", exact=True).press("Enter")
    expect(editor).to_have_text("//frame[motion_name = 'left-leg-flexion' and position() >= 20 and position() <= 100]")
    expect(page.get_by_role("status").filter(has_text="6 frames in 1 run")).to_be_visible()
    builder.get_by_role("button", name="any of these holds").click()
    builder.get_by_role("button", name="Value of a bone").press("Enter")
    builder.get_by_label("Bone", exact=True).select_option("left_foot")
    builder.get_by_label("Value", exact=True).fill("-400")
    expect(editor).to_have_text(re.compile(r" or frame_bone\[@name = 'left_foot'\]/@Rx > -400\]$"))
    page.keyboard.press("Enter")
    expect(page.get_by_role("status").filter(has_text="60 frames in 1 run")).to_be_visible()
    builder.get_by_role("button", name="Remove condition 1").click()
    expect(editor).not_to_have_text(re.compile("motion_name"))
    editor.press("Control+End")
    page.keyboard.type(" ")
    page.keyboard.type("| //name")
    expect(page.get_by_text("The expression below was written by hand.")).to_be_visible()
    page.get_by_role("button", name="Use the builder instead").click()
    expect(builder.get_by_label("Bone", exact=True)).to_have_value("left_foot")
    expect(editor).not_to_have_text(re.compile("//name"))


def test_examples_find_something_and_become_lines_for_scripts(open_studio: Served, visit_of: Any) -> None:
    open_studio.upload("kick.bvh", walk(), label="it's a kick:10-25")
    visit = visit_of(open_studio, permissions=["clipboard-read", "clipboard-write"])
    page = visit.open("/xpath")
    page.get_by_role("button", name=re.compile("^Frames of one motion name.*it's")).click()
    expect(page.get_by_role("status").filter(has_text="16 frames in 1 run")).to_be_visible()
    page.get_by_role("button", name="Copy").click()
    page.get_by_role("menuitem", name="as Python").click()
    expect(page.get_by_text("Copied")).to_be_visible()
    line = page.evaluate("navigator.clipboard.readText()")
    found: dict[str, Any] = {}
    exec(line.split("\nfor ")[0], found)
    assert [(run.first, run.last) for run in found["found"].runs()] == [(10, 25)]


def test_completions_say_how_many_clips_have_a_name(open_studio: Served, visit_of: Any) -> None:
    for number in range(2):
        open_studio.upload(f"kick_{number}.bvh", walk(seed=number), label="kick")
    page = visit_of(open_studio).open("/xpath")
    expect(page.get_by_role("textbox", name="XPath")).to_be_focused()
    page.keyboard.type("//frame[motion_name='k")
    expect(page.locator(".cm-completionDetail").filter(has_text="2 clips")).to_be_visible()
