"""The composer: pieces with speeds and mirrors, seams of their own, layers, runs of a question, all with undo."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest

from mcml.formats import FORMATS
from mcml_service.demo import body
from tests.web.conftest import Served

expect: Any = pytest.importorskip("playwright.sync_api").expect


@pytest.fixture
def board(open_studio: Served, visit_of: Any) -> Any:
    """A page with two pieces, of the clips `one` (42 frames of a walk) and `two` (30 of a wave, 11-20 are named)."""
    one = open_studio.upload("one.bvh", person("one", body.walk(170.0, 0.7, 1.0, 6.0)))
    two = open_studio.upload("two.bvh", person("two", body.wave(170.0, 0.5, 1.5)), label="kick:11-20")
    page = visit_of(open_studio).open(f"/compose?s={one},{two}")
    shown(page, "in 2 segments")
    return page


def person(name: str, motion: Any) -> bytes:
    return b"".join(FORMATS["bvh"].write(body.clip(name, 170.0, *motion), "bvh"))


def shown(page: Any, text: str) -> None:
    expect(page.get_by_role("status").filter(has_text=text)).to_be_visible()


def segments_asked(page: Any, act: Any) -> list[dict[str, Any]]:
    """What the preview that follows an act asks for."""
    with page.expect_response(lambda answer: "/compose" in answer.url and answer.request.method == "POST") as answer:
        act()
    assert answer.value.status == 200, answer.value.text()
    return list(answer.value.request.post_data_json["segments"])


def fill(field: Any, text: str) -> None:
    field.fill(text)
    field.press("Enter")


@pytest.mark.slow
def test_a_piece_has_its_speed_and_is_mirrored_and_a_reload_keeps_it(board: Any) -> None:
    piece = board.get_by_role("group", name="Segment 1")
    asked = segments_asked(board, lambda: fill(piece.get_by_label("Speed"), "2"))
    assert asked[0]["speed"] == 2
    asked = segments_asked(board, lambda: piece.get_by_role("button", name="Mirror").click())
    assert asked[0]["mirror"]
    board.wait_for_url(re.compile("_x2_m"))
    board.reload()
    expect(board.get_by_role("button", name=re.compile(r"Segment 1: one ?1–42 ?× 2 ?mirrored"))).to_be_visible()
    # Without an address it is there too: what was in work is kept.
    board.goto(board.url.split("?")[0])
    expect(board.get_by_role("button", name=re.compile(r"Segment 1: one ?1–42 ?× 2 ?mirrored"))).to_be_visible()


@pytest.mark.slow
def test_a_seam_has_its_own_transition_and_undo_takes_each_step_back(board: Any) -> None:
    seam = board.get_by_role("button", name=re.compile("^Seam 1 to 2"))
    seam.click()
    form = board.get_by_role("group", name="Seam", exact=True)
    expect(form.get_by_role("status")).to_contain_text(re.compile("the largest step is"))
    asked = segments_asked(board, lambda: fill(form.get_by_label("Transition", exact=True), "5"))
    assert [one["transition"] for one in asked] == [None, 5]
    asked = segments_asked(board, lambda: form.get_by_role("button", name="Crossfade", exact=True).click())
    assert [one["style"] for one in asked] == [None, "crossfade"]
    asked = segments_asked(board, lambda: board.keyboard.press("Control+z"))
    assert (asked[1]["transition"], asked[1]["style"]) == (5, None)
    asked = segments_asked(board, lambda: board.keyboard.press("Control+z"))
    assert asked[1]["transition"] is None
    asked = segments_asked(board, lambda: board.keyboard.press("Control+Shift+z"))
    assert asked[1]["transition"] == 5


@pytest.mark.fuzz
def test_walks_meet_in_phase_if_asked(open_studio: Any, visit_of: Any) -> None:
    uuid = open_studio.upload("long.bvh", person("long", body.walk(170.0, 4.0, 1.0, 6.0)))
    page = visit_of(open_studio).open(f"/compose?s={uuid}:1-150,{uuid}:33-200")
    shown(page, "in 2 segments")
    page.get_by_role("button", name="Match phase").click()
    page.wait_for_url(re.compile("phase=match"))
    page.get_by_role("button", name=re.compile("^Seam 1 to 2")).click()
    expect(page.get_by_text(re.compile(r"Frames left out: \d+ before, \d+ after"))).to_be_visible()
    page.reload()
    expect(page.get_by_role("button", name="Match phase")).to_have_attribute("aria-pressed", "true")


@pytest.mark.slow
def test_edges_snap_to_names(board: Any) -> None:
    piece = board.get_by_role("button", name=re.compile("^Segment 2: two"))
    box = piece.bounding_box()
    per_frame = box["width"] / 30
    board.mouse.move(box["x"] + box["width"] - 3, box["y"] + 20)
    board.mouse.down()
    board.mouse.move(box["x"] + box["width"] - 3 - 10 * per_frame - 4, box["y"] + 20, steps=4)
    expect(board.get_by_role("status").filter(has_text="20 kick")).to_be_visible()
    asked = segments_asked(board, board.mouse.up)
    assert (asked[1]["first"], asked[1]["last"]) == (1, 20)
    # A drag that Esc ends has done nothing.
    box = board.get_by_role("button", name=re.compile("^Segment 1: one")).bounding_box()
    board.mouse.move(box["x"] + 3, box["y"] + 20)
    board.mouse.down()
    board.mouse.move(box["x"] + 80, box["y"] + 20, steps=3)
    board.keyboard.press("Escape")
    board.mouse.up()
    expect(board.get_by_role("button", name=re.compile("^Segment 1: one ?1–42"))).to_be_visible()


@pytest.mark.slow
def test_a_layer_moves_chosen_joints(board: Any) -> None:
    segments_asked(board, lambda: board.get_by_role("button", name="Add as a layer two").click())
    form = board.get_by_role("group", name="Layer", exact=True)
    asked = segments_asked(board, lambda: fill(form.get_by_label("begins at"), "5"))
    layer = asked[0]["layers"][0]
    assert layer["at"] == 5
    form.get_by_role("button", name="Choose joints").click()
    dialog = board.get_by_role("dialog", name="Choose joints")
    asked = segments_asked(board, lambda: dialog.get_by_label("left_foot").click())
    assert set(asked[0]["layers"][0]["bones"]) ^ set(layer["bones"]) == {"left_foot"}
    board.keyboard.press("Escape")
    board.get_by_role("button", name="Save as clip").click()
    board.wait_for_url(re.compile("/clips/"))


@pytest.mark.fuzz
def test_runs_of_a_question_become_pieces(board: Any) -> None:
    board.get_by_role("searchbox", name="Search").fill("//frame[motion_name='kick']")
    asked = segments_asked(board, lambda: board.get_by_role("button", name="Add two 11–20").click())
    assert [(one["first"], one["last"]) for one in asked] == [(1, 42), (1, 30), (11, 20)]
    board.get_by_role("button", name="Add all 1").click()
    expect(board.get_by_role("group", name="Segments").get_by_role("button", name="Segment")).to_have_count(4)
    board.wait_for_url(lambda url: parse_qs(urlsplit(url).query)["s"][0].count(",") == 3)


@pytest.mark.slow
def test_clips_are_dragged_onto_the_storyboard(board: Any) -> None:
    bin_row = board.locator(".bin-list li").filter(has_text="two")
    bin_row.drag_to(board.get_by_role("button", name=re.compile("^Segment 1: one")), target_position={"x": 5, "y": 20})
    expect(board.get_by_role("button", name=re.compile("^Segment 1: two"))).to_be_visible()
    bin_row.drag_to(board.locator(".layer-lane").nth(1))
    expect(board.get_by_role("button", name=re.compile("^Layer: two"))).to_be_visible()
