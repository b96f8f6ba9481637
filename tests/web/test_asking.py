"""The XPath console for those who do not know XPath: choices, examples, lines for scripts."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import quote

import pytest

from mcml.formats import FORMATS
from mcml_service.demo.walks import walks
from tests.web.conftest import Served, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect


@pytest.mark.slow
def test_a_question_is_built_by_keys_alone_and_folds_when_it_is_written_by_hand(
    open_studio: Served, visit_of: Any
) -> None:
    open_studio.upload("kick.bvh", walk(), label="left-leg-flexion:10-25")
    page = visit_of(open_studio).open("/xpath")
    editor = page.get_by_role("textbox", name="XPath")
    expect(editor).to_be_focused()
    builder = page.get_by_role("form", name="Builder")
    builder.get_by_role("button", name="Label").press("Enter")
    expect(editor).to_have_text("//frame[motion_name = 'left-leg-flexion']")
    expect(builder.get_by_label("Label", exact=True).locator("option:checked")).to_have_text(
        "left-leg-flexion (1 clip)"
    )
    builder.get_by_role("button", name="Frame number").press("Enter")
    builder.get_by_label("from", exact=True).fill("20")
    builder.get_by_label("from", exact=True).press("Enter")
    expect(editor).to_have_text("//frame[motion_name = 'left-leg-flexion' and position() >= 20 and position() <= 100]")
    expect(page.get_by_role("status").filter(has_text="6 frames in 1 range")).to_be_visible()
    builder.get_by_role("button", name="match any").click()
    builder.get_by_role("button", name="Joint channel").press("Enter")
    builder.get_by_label("Joint", exact=True).select_option("left_foot")
    builder.get_by_label("Value", exact=True).fill("-400")
    expect(editor).to_have_text(re.compile(r" or frame_bone\[@name = 'left_foot'\]/@Rx > -400\]$"))
    page.keyboard.press("Enter")
    expect(page.get_by_role("status").filter(has_text="60 frames in 1 range")).to_be_visible()
    builder.get_by_role("button", name="Remove condition 1").click()
    expect(editor).not_to_have_text(re.compile("motion_name"))
    editor.press("Control+End")
    page.keyboard.type(" ")
    page.keyboard.type("| //name")
    expect(page.get_by_text("The builder cannot show this expression.")).to_be_visible()
    page.get_by_role("button", name="Use the builder").click()
    expect(builder.get_by_label("Joint", exact=True)).to_have_value("left_foot")
    expect(editor).not_to_have_text(re.compile("//name"))


def upload_walks(studio: Served, count: int) -> None:
    for number, clip in enumerate(walks()[:count]):
        studio.upload(f"walk_{number}.bvh", b"".join(FORMATS["bvh"].write(clip, "bvh")))


@pytest.mark.slow
def test_a_question_about_bodies_is_asked_without_xpath(open_studio: Served, visit_of: Any) -> None:
    upload_walks(open_studio, 3)
    page = visit_of(open_studio).open("/xpath")
    editor = page.get_by_role("textbox", name="XPath")
    builder = page.get_by_role("form", name="Builder")
    status = page.get_by_role("status").filter(has_text=re.compile("frames in .* range"))
    builder.get_by_role("button", name="Measurement").click()
    first = builder.get_by_role("group", name="Condition 1")
    expect(first.get_by_label("Joint", exact=True).locator("option:checked")).to_contain_text("left hand")
    builder.get_by_role("button", name="Ground contact").click()
    second = builder.get_by_role("group", name="Condition 2")
    expect(second.get_by_label("Link to condition 2").locator("option:checked")).to_have_text("while")
    expect(editor).to_have_text("//frame[mo:speed('left_hand') > 1 and mo:contact('right_toes')]")
    expect(status).to_be_visible()
    cards = page.get_by_role("list", name="First matches, moving").get_by_role("button")
    expect(cards.first).to_be_visible()
    rows = page.get_by_role("listbox", name="Results").get_by_role("option")
    before = status.inner_text()
    # The slider changes the expression, the count and the hits.
    slider = first.get_by_role("slider")
    slider.focus()
    slider.press("End")
    expect(editor).not_to_have_text(re.compile("> 1 and"))
    expect(status).not_to_have_text(before)
    slider.press("Home")
    expect(status).to_be_visible()
    # By the smallest mean speed first, then by the greatest.
    mean = page.get_by_role("button", name="Sort by mean mo:speed('left_hand')")
    mean.click()
    expect(mean).to_have_attribute("aria-pressed", "true")
    figures = rows.locator(".figure:last-child")
    falling = [float(one) for one in figures.all_inner_texts()]
    assert falling == sorted(falling, reverse=True)
    assert falling[0] > falling[-1]
    # Then, within a second; and in step with the text both ways.
    second.get_by_label("Link to condition 2").select_option("then")
    expect(editor).to_have_text(re.compile(r"and mo:window\(0, 1\)\[mo:contact\('right_toes'\)\]\]$"))
    editor.press("Control+a")
    page.keyboard.insert_text("//frame[not(mo:activity('walk'))]")
    expect(builder.get_by_role("group", name="Condition 2")).to_have_count(0)
    expect(first.get_by_label("Activity").locator("option:checked")).to_have_text("walk")
    expect(first.get_by_label("Comparison").locator("option:checked")).to_have_text("is not")


@pytest.mark.slow
def test_a_joint_is_picked_on_a_body(open_studio: Served, visit_of: Any) -> None:
    upload_walks(open_studio, 1)
    page = visit_of(open_studio).open("/xpath")
    builder = page.get_by_role("form", name="Builder")
    builder.get_by_role("button", name="Measurement").click()
    joint = builder.get_by_role("group", name="Condition 1").get_by_label("Joint", exact=True)
    expect(joint).to_have_value("left_hand")
    body = builder.get_by_role("img", name="Body")
    expect(body.locator(".stage-canvas")).to_be_visible()
    box = body.bounding_box()
    picked = set()
    # From head to floor along the middle of the body there are joints.
    for share in range(2, 19):
        body.click(position={"x": box["width"] / 2, "y": box["height"] * share / 20})
        picked.add(joint.input_value())
    assert len(picked) > 2, picked


@pytest.mark.slow
def test_guesses_are_left_out_by_a_switch(open_studio: Served, visit_of: Any) -> None:
    upload_walks(open_studio, 1)
    question = quote("//frame[mo:height('Head') > 0.1]")
    page = visit_of(open_studio).open(f"/xpath?q={question}")
    expect(page.get_by_role("status").filter(has_text="in 1 range")).to_be_visible()
    page.get_by_role("button", name="Exclude guessed units").click()
    expect(page.get_by_role("heading", name="No matches")).to_be_visible()
    page.wait_for_url("**guesses=no*")
    # Composing cannot leave out guesses: the button says so, and is not hidden.
    open_studio.upload("kick.bvh", walk(), label="kick:10-25")
    page.goto(open_studio.url + "/xpath?guesses=no&q=" + quote("//frame[motion_name='kick']"))
    save = page.get_by_role("button", name="Save as clip")
    expect(save).to_be_disabled()
    expect(save).to_have_attribute("title", re.compile("guessed units"))
    page.get_by_role("button", name="Exclude guessed units").click()
    expect(save).to_be_enabled()


@pytest.mark.slow
def test_examples_find_something_and_become_lines_for_scripts(open_studio: Served, visit_of: Any) -> None:
    open_studio.upload("kick.bvh", walk(), label="it's a kick:10-25")
    visit = visit_of(open_studio, permissions=["clipboard-read", "clipboard-write"])
    page = visit.open("/xpath")
    page.get_by_role("button", name=re.compile("^Frames with the label it's")).click()
    expect(page.get_by_role("status").filter(has_text="16 frames in 1 range")).to_be_visible()
    page.get_by_role("button", name="Copy").click()
    page.get_by_role("menuitem", name="Python").click()
    expect(page.get_by_text("Copied")).to_be_visible()
    line = page.evaluate("navigator.clipboard.readText()")
    found: dict[str, Any] = {}
    exec(line.split("\nfor ")[0], found)
    assert [(run.first, run.last) for run in found["found"].runs()] == [(10, 25)]


@pytest.fixture
def asked(open_studio: Served, visit_of: Any) -> Any:
    """asked(question, **of_the_visitor): the console with its answer, over two clips of 60 and 40 frames."""
    for name, frames in (("first.bvh", 60), ("second.bvh", 40)):
        open_studio.upload(name, walk(frames), label="kick")

    def ask(question: str, more: str = "", **visitor: Any) -> Any:
        visit = visit_of(open_studio, **visitor)
        visit.wanted = {422}  # that an answer has no runs
        return visit.open(f"/xpath?q={quote(question)}{more}")

    return ask


@pytest.mark.parametrize(
    ("question", "said", "values"),
    [
        ("for $d in //header return string($d/filename)", "2 values", ["first.bvh", "second.bvh"]),
        ("1 to 5", "5 values", ["1", "2", "3", "4", "5"]),
        ("distinct-values(//motion_name)", "1 value", ["kick"]),
        ("string(//source/@part)", "2 values", ["bvh", "bvh"]),
        ("//frame[1]/motion_name/text()", "2 items", ["kick", "kick"]),
        ("string(//nothing)", "2 values", ["empty text", "empty text"]),
    ],
)
def test_values_are_listed(asked: Any, question: str, said: str, values: list[str]) -> None:
    page = asked(question, "&as=nodes")
    expect(page.get_by_role("status").filter(has_text=said)).to_be_visible()
    expect(page.get_by_role("option").locator("code")).to_have_text(values)
    expect(page.get_by_role("alert")).to_have_count(0)


@pytest.mark.parametrize(
    ("question", "value"),
    [
        ("count(//frame)", "100"),
        ("string-join(distinct-values(//motion_name), ', ')", "kick"),
        ("string-join(//motion_name, ', ')", ", ".join(["kick"] * 100)),
        ("string-join((), '')", "empty text"),
    ],
)
def test_one_value_is_read_at_once_also_where_runs_were_asked_for(asked: Any, question: str, value: str) -> None:
    page = asked(question)
    expect(page.get_by_role("status").filter(has_text="1 value")).to_be_visible()
    expect(page.locator(".xpath-value output")).to_have_text(value)
    expect(page.get_by_role("alert")).to_have_count(0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("locale", "switch", "by_itself"),
    [("en", "per clip", "each clip separately"), ("ko", "클립마다", "클립마다 따로")],
)
def test_each_document_is_asked_by_itself(asked: Any, locale: str, switch: str, by_itself: str) -> None:
    page = asked("count(//frame)", locale=locale)
    expect(page.locator(".xpath-value output")).to_have_text("100")
    button = page.get_by_role("button", name=switch, exact=True)
    expect(button).to_have_attribute("aria-pressed", "false")
    assert "count(//frame)" in button.get_attribute("title")
    button.click()
    rows = page.get_by_role("listbox", name=re.compile("Results|결과")).get_by_role("option")
    expect(rows).to_contain_text([re.compile("60.*first"), re.compile("40.*second")])
    expect(page.get_by_role("status").filter(has_text=by_itself)).to_be_visible()
    page.wait_for_url("**per=document*")
    page.reload()
    expect(rows).to_have_count(2)
    expect(button).to_have_attribute("aria-pressed", "true")
    export = page.get_by_role("button", name=re.compile("Export all|모두 내보내기"))
    export.click()
    assert "per=document" in page.get_by_role("menuitem", name="CSV").get_attribute("href")
    button.click()
    expect(page.locator(".xpath-value output")).to_have_text("100")
    page.wait_for_url(re.compile(r"^((?!per=).)*$"))


def test_a_long_value_is_shown_whole_and_its_document_opened(asked: Any) -> None:
    page = asked("//bone[1]", "&as=nodes", viewport={"width": 400, "height": 800})
    whole = page.locator(".xpath-whole")
    expect(whole).to_contain_text("</bone>")
    # In a narrow window the table stays below what is above it.
    status, table = page.locator(".xpath-status").bounding_box(), page.locator(".xpath-table").bounding_box()
    assert table["y"] >= status["y"] + status["height"]
    assert table["y"] + table["height"] <= 800
    whole.get_by_role("link", name="first").click()
    page.wait_for_url("**/clips/*")


def test_completions_say_how_many_clips_have_a_name(open_studio: Served, visit_of: Any) -> None:
    for number in range(2):
        open_studio.upload(f"kick_{number}.bvh", walk(seed=number), label="kick")
    page = visit_of(open_studio).open("/xpath")
    expect(page.get_by_role("textbox", name="XPath")).to_be_focused()
    page.keyboard.type("//frame[motion_name='k")
    expect(page.locator(".cm-completionDetail").filter(has_text="2 clips")).to_be_visible()


def test_run_closes_the_list_of_completions(open_studio: Served, visit_of: Any) -> None:
    open_studio.upload("one.bvh", walk())
    page = visit_of(open_studio).open("/xpath")
    editor = page.get_by_role("textbox", name="XPath")
    expect(editor).to_be_focused()
    page.keyboard.type("//frame")
    completions = page.get_by_role("listbox", name="Completions")
    expect(completions).to_be_visible()
    page.locator(".xpath-editor").get_by_role("button", name="Run").dispatch_event("click")
    expect(completions).to_have_count(0)
    expect(page.get_by_role("status").filter(has_text="60 frames in 1 range")).to_be_visible()
