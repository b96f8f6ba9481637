"""Files that are dropped: each has a row with what became of it, why, and what to do."""

from __future__ import annotations

import csv
import io
import re
import zipfile
from pathlib import Path
from typing import Any

import pytest

from tests.web.conftest import Served, Visit, one_door, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect


def zipped(files: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return buffer.getvalue()


HEAD = b"HIERARCHY\nROOT Hips\n{\n OFFSET 0 0\n}\n"
GOOD = {"walk.bvh": walk(4), "again.bvh": walk(4), "all.zip": zipped({"one.bvh": walk(5), "two.bvh": walk(6)})}
REFUSED = {
    "bad.bvh": (HEAD, "line"),
    "empty.bvh": (b"", "empty"),
    "empty.zip": (b"", "empty"),
    "model.fbx": (b"Kaydara FBX Binary  \x00\x1a\x00", "FBX"),
    "notes.txt": (b"take 3 was the best", "none of the supported formats"),
    "picture.jpg": (b"\xff\xd8\xff\xe0\x00\x10JFIF\x00", "image"),
    "facts.json": (b"{}", "JSON"),
    "page.bvh": (b"<!doctype html><html></html>", "web page"),
    "noending": (b"\x00\x01\x02\x03", "no motion format"),
    ".DS_Store": (b"\x00\x00\x00\x01Bud1", "no motion format"),
}


def drop(page: Any, files: dict[str, bytes]) -> None:
    page.evaluate(
        """files => {
          const data = new DataTransfer();
          for (const [name, bytes] of files) data.items.add(new File([new Uint8Array(bytes)], name));
          for (const kind of ["dragenter", "dragover", "drop"])
            document.body.dispatchEvent(new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true }));
        }""",
        [[name, list(content)] for name, content in files.items()],
    )


@pytest.mark.slow
@one_door
def test_each_dropped_file_has_a_row_with_what_became_of_it(visit: Visit, studio: Served) -> None:
    visit.wanted = {415, 422}
    page = visit.open("/library")
    expect(page.get_by_role("button", name="Import", exact=True)).to_be_visible()
    drop(page, GOOD | {name: content for name, (content, _) in REFUSED.items()})
    tray = page.get_by_role("region", name="Import")
    count = len(GOOD) + len(REFUSED)
    expect(tray.locator("header .pace")).to_have_text(f"{count} of {count} done")
    rows = tray.get_by_role("table", name="Import report").locator("tbody tr")
    expect(rows).to_have_count(count + 1)  # The archive holds two clips.
    for name, (_, why) in REFUSED.items():
        row = rows.filter(has=page.get_by_title(name, exact=True))
        expect(row).to_contain_text("import failed")
        expect(row.locator(".refusal")).to_contain_text(why)
        expect(row.locator(".refusal p")).not_to_have_count(0)
    same = rows.filter(has_text="Duplicate of a clip")
    expect(same).to_have_count(1)
    for name in ("one.bvh", "two.bvh"):
        expect(rows.filter(has_text=name).get_by_role("link", name="Open")).to_be_visible()
    assert studio.get("/documents")["total"] == 4


@pytest.mark.slow
@one_door
def test_a_long_file_of_an_unknown_kind_is_not_sent_whole(visit: Visit, studio: Served) -> None:
    sent: list[int] = []
    page = visit.open("/library")
    expect(page.get_by_role("button", name="Import", exact=True)).to_be_visible()
    page.on("request", lambda one: sent.append(len(one.post_data_buffer or b"")) if one.method == "POST" else None)
    page.evaluate(
        """([head, size]) => {
          const data = new DataTransfer();
          data.items.add(new File([new Uint8Array(head), new Uint8Array(size)], "film.mp4"));
          for (const kind of ["dragenter", "dragover", "drop"])
            document.body.dispatchEvent(new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true }));
        }""",
        [list(b"\x00\x00\x00\x18ftypmp42"), 20 << 20],
    )
    row = page.get_by_role("region", name="Import").locator("tbody tr").first
    expect(row).to_contain_text(re.compile("import failed.*Unsupported error", re.DOTALL))
    assert sum(sent) < 1 << 20


def test_the_report_is_filtered_saved_selected_and_folded(open_studio: Served, visit_of: Any) -> None:
    """An archive with clips in two folders, a broken file and a duplicate of another file."""
    held = {f"day{n % 2}/clip{n}.bvh": walk(5 + n, seed=n) for n in range(30)} | {"day0/broken.bvh": HEAD}
    page = visit_of(open_studio).open("/library")
    expect(page.get_by_role("button", name="Import", exact=True)).to_be_visible()
    drop(page, {"alone.bvh": walk(4), "same.bvh": walk(4), "all.zip": zipped(held)})
    tray = page.get_by_role("region", name="Import")
    expect(tray.locator("header")).to_contain_text("1 import failed · 1 already here · 31 imported")
    rows = tray.get_by_role("table", name="Import report").locator("tbody tr")
    expect(rows).to_have_count(33)
    outcomes = tray.get_by_role("group", name="Outcome")
    for name, count in (("import failed", 1), ("already here", 1), ("imported", 31), ("All", 33)):
        outcomes.get_by_role("button", name=f"{name} {count}").click()
        expect(rows).to_have_count(count)
    with page.expect_download() as download:
        tray.get_by_role("button", name="Download CSV").click()
    text = Path(download.value.path()).read_text(encoding="utf-8-sig")
    report = {row["file"]: row for row in csv.DictReader(io.StringIO(text))}
    assert set(report) == {*held, "alone.bvh", "same.bvh"}
    broken = report["day0/broken.bvh"]
    assert (broken["outcome"], broken["line"], bool(broken["remedy"])) == ("import failed", "5", True)
    stored = {row["address"] for row in report.values() if row["address"]}
    ids = {document["id"] for document in open_studio.get("/documents", limit=100)["items"]}
    assert stored == {f"{open_studio.url}/clips/{uuid}" for uuid in ids}
    tray.get_by_role("button", name="Select all 32 imported clips").click()
    expect(page.get_by_role("toolbar", name="32 selected")).to_be_visible()
    # One line of it is left, below the page, on others too.
    expect(rows).to_have_count(0)
    page.get_by_role("link", name="Measure").click()
    page_box, line = page.locator("main").bounding_box(), tray.bounding_box()
    assert line["height"] < 60
    assert page_box["y"] + page_box["height"] <= line["y"] + 1
    tray.get_by_role("button", name="Show report").click()
    expect(rows).to_have_count(33)
    page.keyboard.press("Escape")
    expect(tray.get_by_role("button", name="Show report")).to_be_focused()
    tray.get_by_role("button", name="Close").click()
    expect(tray).to_have_count(0)
