"""What a newcomer does, in a real browser: on an open personal server, and with a session."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path
from typing import Any

import pytest

from tests.builders import TRC
from tests.web.conftest import Served, Visit, one_door, open_door, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect


def drop(page: Any, path: Path) -> None:
    """Drop a file on the window, as a hand does."""
    data = page.evaluate_handle(
        """([name, text]) => {
            const data = new DataTransfer();
            data.items.add(new File([text], name));
            return data;
        }""",
        [path.name, path.read_text()],
    )
    page.dispatch_event("body", "dragenter", {"dataTransfer": data})
    page.dispatch_event(".drop-field >> nth=0", "dragover", {"dataTransfer": data})
    page.dispatch_event(".drop-field >> nth=0", "drop", {"dataTransfer": data})


def ready(page: Any) -> None:
    """Until the clip's first frame is drawn."""
    page.wait_for_function("() => performance.getEntriesByName('first-frame').length > 0")


@pytest.mark.slow
def test_dropped_files_are_stored_and_seen(visit: Visit, studio: Served, tmp_path: Path) -> None:
    file = tmp_path / "stride.bvh"
    file.write_bytes(walk())
    page = visit.open("/")
    expect(page.get_by_role("heading", name="No clips yet")).to_be_visible()
    drop(page, file)
    tray = page.get_by_role("region", name="Import")
    expect(tray.get_by_text("imported", exact=True)).to_be_visible()
    expect(tray.get_by_text(re.compile("4 of 4 mapped"))).to_be_visible()
    tray.get_by_role("button", name="cm").click()
    expect(page.get_by_role("gridcell", name=re.compile("stride"))).to_be_visible()
    document = studio.get("/documents")["items"][0]
    expect(tray.get_by_role("button", name="cm")).to_have_count(0)
    body = tray.locator(".calibrated span:not([class])")
    expect(body.filter(has_text="Unit")).to_have_text("Unit cm from the file")
    expect(body.filter(has_text="Up")).to_have_text("Up -Y guessed")
    assert studio.get(f"/documents/{document['id']}")["unit"] == "cm"
    tray.get_by_role("link", name="Open").click()
    ready(page)
    expect(page.get_by_role("heading", name="stride", include_hidden=True).first).to_be_attached()
    assert len(colours_of(page)) > 50, "the viewer is not blank"


def colours_of(page: Any) -> set[tuple[int, ...]]:
    """The colours of the viewer as they are on the screen."""
    from PIL import Image

    picture = Image.open(io.BytesIO(page.locator(".stage").screenshot())).convert("RGB")
    return {tuple(colour) for _, colour in picture.getcolors(1 << 24) or []}


@pytest.mark.slow
@one_door
def test_a_refused_file_says_why_and_stops_no_other(visit: Visit, studio: Served, tmp_path: Path) -> None:
    visit.wanted = {422}
    bad, good = tmp_path / "bad.bvh", tmp_path / "good.bvh"
    bad.write_text("HIERARCHY\nROOT Hips\n{\n OFFSET 0 0\n}\n")
    good.write_bytes(walk())
    page = visit.open("/library")
    drop(page, bad)
    drop(page, good)
    tray = page.get_by_role("region", name="Import")
    expect(tray.get_by_text("import failed", exact=True)).to_be_visible()
    expect(tray.get_by_text("imported", exact=True)).to_be_visible()
    expect(tray.locator(".refusal")).to_contain_text("line")
    assert studio.get("/documents")["total"] == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("language", "pace", "done"),
    [
        ("en", r"\d+ of 100 · [\d.]+ files? a second · \d+ s left", "100 of 100 done"),
        pytest.param(
            "ko", r"100개 중 \d+개 · 초당 [\d.]+개 · \d+ s 남음", "100개 중 100개 완료", marks=pytest.mark.fuzz
        ),
    ],
)
def test_many_files_say_how_fast_they_go(
    open_studio: Served, visit_of: Any, tmp_path: Path, language: str, pace: str, done: str
) -> None:
    files = [tmp_path / f"clip{number:02}.bvh" for number in range(100)]
    for number, file in enumerate(files):
        file.write_bytes(walk(4, seed=number))
    asked: list[Any] = []
    held = True

    def hold_the_last(one: Any) -> None:
        # 32 files share a request; the first of all is by itself.
        asked.append(one)
        if len(asked) < 4 or not held:
            one.continue_()

    page = visit_of(open_studio, locale=language).open("/library")
    page.route("**/api/v1/documents", hold_the_last)
    header = page.locator(".tray header")

    def choose(some: list[Path]) -> None:
        with page.expect_file_chooser() as chooser:
            page.locator(".toolbar .primary").click()
        chooser.value.set_files(some)

    choose(files[:1])
    expect(page.locator(".tray .stored")).to_have_count(1)
    expect(header.locator(".pace")).to_have_count(0)
    header.get_by_role("button").last.click()
    choose(files)
    expect(header).to_contain_text(re.compile(pace))
    held = False
    for one in asked[3:]:
        one.continue_()
    expect(header.locator(".pace")).to_have_text(done)
    expect(header.get_by_role("status")).to_have_text(done)
    assert open_studio.get("/documents")["total"] == 101
    assert len(asked) == 5


@one_door
def test_files_that_share_a_request_have_their_own_rows(visit: Visit, studio: Served, tmp_path: Path) -> None:
    files = [tmp_path / f"{name}.bvh" for name in ("first", "bad", "second")]
    for number, file in enumerate(files):
        file.write_bytes(walk(4, seed=number) if file.stem != "bad" else b"HIERARCHY\nROOT Hips\n{\n OFFSET 0 0\n}\n")
    page = visit.open("/library")
    with page.expect_file_chooser() as chooser:
        page.locator(".toolbar .primary").click()
    chooser.value.set_files(files)
    tray = page.get_by_role("region", name="Import")
    expect(tray.get_by_text("imported", exact=True)).to_have_count(2)
    refused = tray.get_by_role("row").filter(has_text="import failed")
    expect(refused).to_contain_text("bad.bvh")
    expect(refused.locator(".refusal")).to_contain_text("line")
    for document in studio.get("/documents")["items"]:
        row = tray.get_by_role("row").filter(has_text=f"{document['name']}.bvh")
        expect(row.get_by_role("link", name="Open")).to_have_attribute("href", f"/clips/{document['id']}")


@pytest.mark.slow
@one_door
def test_frames_are_found_by_name_and_played(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(), label="left-leg-flexion:10-25")
    page = visit.open("/xpath")
    expect(page.get_by_role("textbox", name="XPath")).to_be_focused()
    page.keyboard.type("//frame[motion_name='left-leg-flexion']", delay=1)
    page.keyboard.press("Escape")
    page.keyboard.press("Control+Enter")
    expect(page.get_by_role("status").filter(has_text="16 frames in 1 range")).to_be_visible()
    page.get_by_role("listbox").get_by_role("option").first.dblclick()
    page.wait_for_url(re.compile(f"/clips/{uuid}"))
    ready(page)
    assert "in=10" in page.url
    assert "out=25" in page.url


@pytest.mark.slow
@open_door
def test_two_clips_are_composed(visit: Visit, studio: Served) -> None:
    one, two = studio.upload("one.bvh", walk(40)), studio.upload("two.bvh", walk(30, seed=3))
    page = visit.open("/compose")
    page.get_by_role("button", name="Add one").click()
    page.get_by_role("button", name="Add two").click()
    expect(page.get_by_role("group", name="Segments").get_by_role("button", name="Segment")).to_have_count(2)
    expect(page.get_by_role("status").filter(has_text="in 2 segments")).to_be_visible()
    assert f"s={one},{two}" in page.url.replace("%2C", ",")
    page.get_by_label("to", exact=True).fill("20")
    page.get_by_label("to", exact=True).press("Enter")
    page.get_by_label("Name of the new clip").fill("both")
    page.get_by_role("button", name="Save as clip").click()
    page.wait_for_url(re.compile("/clips/"))
    ready(page)
    both = next(item for item in studio.get("/documents")["items"] if item["name"] == "both")
    assert both["frames"] > 20 + 40 - 1


@pytest.mark.slow
@one_door
def test_a_motion_is_put_on_another_body(visit: Visit, studio: Served) -> None:
    one, body = studio.upload("one.bvh", walk(40)), studio.upload("body.bvh", walk(1, seed=3))
    page = visit.open(f"/retarget?from={one}&to={body}")
    expect(page.get_by_text("4 of 4 joints")).to_be_visible()
    page.get_by_label("left_foot", exact=True).select_option("not mapped")
    expect(page.get_by_text("3 of 4 joints")).to_be_visible()
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_text("4 of 4 joints")).to_be_visible()
    page.get_by_role("button", name="Retarget").click()
    page.wait_for_url(re.compile("/clips/"))
    ready(page)
    assert "one on body" in {item["name"] for item in studio.get("/documents")["items"]}


@open_door
def test_what_is_exported_comes_back_equal(visit: Visit, studio: Served, tmp_path: Path) -> None:
    content = walk()
    uuid = studio.upload("there.bvh", content)
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.get_by_role("button", name="Export").click()
    with page.expect_download() as download:
        page.get_by_role("menuitem", name=re.compile("^BVH")).click()
    assert Path(download.value.path()).read_bytes() == content
    assert download.value.suggested_filename == "there.bvh"


@one_door
def test_deleted_clips_come_back(visit: Visit, studio: Served) -> None:
    for name in ("a.bvh", "b.bvh", "c.bvh"):
        studio.upload(name, walk(5))
    page = visit.open("/library?sort=name")
    cards = page.get_by_role("gridcell")
    expect(cards).to_have_count(3)
    cards.nth(0).click(modifiers=["Control"])
    cards.nth(2).click(modifiers=["Control"])
    page.get_by_role("toolbar", name="2 selected").get_by_role("button", name="Delete").click()
    expect(cards).to_have_count(1)
    page.get_by_role("status").get_by_role("button", name="Undo").click()
    expect(cards).to_have_count(3)


@pytest.mark.slow
@one_door
def test_picked_clips_are_named_collected_and_exported(visit: Visit, studio: Served) -> None:
    ids = [studio.upload(name, walk(5)) for name in ("a.bvh", "b.bvh", "c.bvh")]
    page = visit.open("/library?sort=name")
    cards = page.get_by_role("gridcell")
    expect(cards).to_have_count(3)
    cards.nth(0).click(modifiers=["Control"])
    cards.nth(1).click(modifiers=["Shift"])
    bar = page.get_by_role("toolbar", name="2 selected")
    bar.get_by_role("button", name="Label", exact=True).click()
    page.get_by_role("combobox", name="Label").fill("standing")
    page.keyboard.press("Enter")
    expect(page.get_by_text("2 clips labelled standing")).to_be_visible()
    assert [len(studio.get(f"/documents/{uuid}")["labels"]) for uuid in ids] == [1, 1, 0]
    bar.get_by_role("button", name="Collect").click()
    page.get_by_role("textbox", name="Name").fill("stills")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="stills").click()
    expect(cards).to_have_count(2)
    assert sorted(studio.get("/collections/stills")["documents"]) == sorted(ids[:2])
    bar.get_by_role("button", name="Export").click()
    with page.expect_download() as download:
        page.get_by_role("menuitem", name="as bvh").click()
    with zipfile.ZipFile(download.value.path()) as found:
        assert sorted(found.namelist()) == ["a.bvh", "b.bvh"]


@one_door
def test_markers_are_offered_as_what_holds_markers(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("m.trc", TRC)
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.get_by_role("button", name="Export").click()
    items = page.get_by_role("menuitem")
    offered = [item.get_attribute("href") for item in items.all() if item.get_attribute("href")]
    assert any("format=c3d" in address for address in offered)
    assert not any("format=bvh" in address for address in offered)
    with studio.client() as client:
        for address in offered:
            assert client.get(address.removeprefix("/api/v1")).status_code == 200, address


@pytest.mark.slow
@one_door
def test_a_question_is_saved_and_its_answer_becomes_a_clip(visit: Visit, studio: Served) -> None:
    studio.upload("kick.bvh", walk(), label="kick:10-25")
    page = visit.open("/xpath?q=//frame[motion_name='kick']")
    expect(page.get_by_role("status").filter(has_text="16 frames in 1 range")).to_be_visible()
    page.get_by_role("button", name="Saved").click()
    page.get_by_role("menuitem", name="Save query").click()
    page.get_by_role("textbox", name="Name").fill("kicks")
    page.keyboard.press("Enter")
    expect(page.get_by_text("Saved as kicks")).to_be_visible()
    assert studio.get("/queries/kicks")["q"] == "//frame[motion_name='kick']"
    page.get_by_role("button", name="Save as clip").click()
    page.get_by_role("status").get_by_role("button", name="Open").click()
    page.wait_for_url(re.compile("/clips/"))
    ready(page)
    made = next(item for item in studio.get("/documents")["items"] if item["name"] != "kick")
    assert made["frames"] == 16


@one_door
def test_keys_alone(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(60))
    page = visit.open("/library")
    expect(page.get_by_role("gridcell")).to_have_count(1)
    page.keyboard.press("?")
    help = page.get_by_role("dialog", name="Keyboard shortcuts")
    expect(help).to_be_visible()
    keys = help.locator("kbd").all_inner_texts()
    assert len(set(keys)) == len(keys) > 10, "no key has two meanings"
    page.keyboard.press("Escape")
    page.keyboard.press("Control+k")
    expect(page.get_by_role("combobox", name="Search everything")).to_be_focused()
    page.keyboard.type("kick")
    expect(page.get_by_role("option", name=re.compile("kick"))).to_be_visible()
    page.keyboard.press("Enter")
    page.wait_for_url(re.compile(uuid))
    ready(page)
    page.keyboard.press("End")
    expect(page.get_by_label("Frame", exact=True)).to_have_value("60")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Shift+ArrowLeft")
    expect(page.get_by_label("Frame", exact=True)).to_have_value("49")
    page.keyboard.press("i")
    page.keyboard.press("End")
    page.keyboard.press("o")
    expect(page.get_by_text("loop 49–60 (12)")).to_be_visible()
    page.keyboard.press("g")
    page.keyboard.press("x")
    page.wait_for_url(re.compile("/xpath"))


@pytest.mark.slow
@open_door
def test_korean(visit: Visit, studio: Served) -> None:
    studio.upload("걷기.bvh", walk(20), label="walk")
    page = visit.open("/library")
    page.get_by_role("button", name="Language").click()
    page.get_by_role("menuitemcheckbox", name="한국어").click()
    expect(page.locator("html")).to_have_attribute("lang", "ko")
    expect(page.get_by_role("button", name="가져오기")).to_be_visible()
    page.get_by_role("gridcell", name=re.compile("걷기")).click()
    ready(page)
    expect(page.get_by_role("tab", name="변경 이력")).to_be_visible()
