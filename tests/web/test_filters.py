"""Filters of the library: ranges by drag and by fields, and filters under names."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.web.conftest import Served, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect


@pytest.fixture
def page(open_studio: Served, visit_of: Any) -> Any:
    """Clips of very different lengths: 3, 30, 300, 3000 frames."""
    for frames in (3, 30, 300, 3000):
        open_studio.upload(f"of_{frames}.bvh", walk(frames))
    page = visit_of(open_studio).open("/library?sort=name")
    expect(page.get_by_role("gridcell")).to_have_count(4)
    return page


@pytest.mark.parametrize("width", [320, pytest.param(400, marks=pytest.mark.fuzz)])
def test_the_tools_stay_in_one_row_on_a_telephone(page: Any, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 800})
    for language in ("English", "한국어"):
        page.get_by_role("button", name=re.compile("Language|언어")).click()
        page.get_by_role("menuitemcheckbox", name=language).click()
        boxes = [one.bounding_box() for one in page.locator(".toolbar > :not(.grow, [role=status])").all()]
        assert len({round(box["y"] + box["height"] / 2) for box in boxes}) == 1
        assert all(box["x"] >= 0 and box["x"] + box["width"] <= width for box in boxes)
        rights = [box["x"] + box["width"] for box in boxes]
        assert all(box["x"] >= right for box, right in zip(boxes[1:], rights, strict=False))
        arrow = page.locator(".toolbar .sort > .icon").bounding_box()
        assert arrow["x"] + arrow["width"] <= boxes[-1]["x"]


def test_lengths_are_chosen_by_drag_by_key_and_by_fields(page: Any) -> None:
    facet = page.get_by_role("region", name="Length")
    bars = facet.locator(".histogram button:enabled")
    expect(bars).to_have_count(4)  # Bins of equal ratio: of equal width would hold three clips in one.
    one, two = bars.nth(1).bounding_box(), bars.nth(2).bounding_box()
    page.mouse.move(one["x"] + 2, one["y"] + 2)
    page.mouse.down()
    page.mouse.move(two["x"] + 2, two["y"] + 2, steps=3)
    page.mouse.up()
    expect(page.get_by_role("gridcell")).to_have_count(2)
    expect(bars).to_have_count(4)
    bars.nth(3).press("Enter")
    expect(page.get_by_role("gridcell", name=re.compile("of_3000"))).to_be_visible()
    expect(page.get_by_role("gridcell")).to_have_count(1)
    facet.get_by_role("button", name="Clear").click()
    facet.get_by_label("Length (s), to").fill("1.5")
    facet.get_by_label("Length (s), to").press("Enter")
    page.wait_for_url(re.compile(r"length=..1\.5"))
    expect(page.get_by_role("gridcell")).to_have_count(2)


def test_filters_are_kept_chosen_shared_and_taken_back(page: Any, open_studio: Served, visit_of: Any) -> None:
    page.goto(f"{open_studio.url}/library?sort=name&length=0.1..&q=of_3")
    expect(page.get_by_role("gridcell")).to_have_count(3)
    page.get_by_role("button", name="Save view").click()
    page.get_by_role("dialog").get_by_role("textbox", name="Name").fill("long ones")
    page.keyboard.press("Enter")
    saved = page.get_by_role("region", name="Saved views").get_by_role("button", name="long ones", exact=True)
    expect(saved).to_have_attribute("aria-pressed", "true")
    saved.click()
    expect(page.get_by_role("gridcell")).to_have_count(4)
    saved.click()
    expect(page.get_by_role("gridcell")).to_have_count(3)
    other = visit_of(open_studio).open(page.url.removeprefix(open_studio.url))
    expect(other.get_by_role("gridcell")).to_have_count(3)
    expect(other.get_by_role("button", name="long ones", exact=True)).to_have_attribute("aria-pressed", "true")
    page.get_by_role("button", name="Remove view long ones").click()
    expect(saved).to_have_count(0)
    page.get_by_role("status").get_by_role("button", name="Undo").click()
    expect(saved).to_be_visible()


def test_any_column_orders_the_library(page: Any) -> None:
    cards, heads = page.get_by_role("gridcell").locator("strong"), page.get_by_role("group", name="Sort by")
    by_name = ["of_3", "of_30", "of_300", "of_3000"]
    page.get_by_role("button", name=re.compile("^Sort by: Name")).click()
    page.get_by_role("menuitemcheckbox", name="Length").click()
    page.wait_for_url(re.compile("sort=-duration"))
    expect(cards).to_have_text(by_name[::-1])
    page.get_by_role("button", name="Sort by: descending").click()
    page.wait_for_url(re.compile("sort=duration"))
    expect(cards).to_have_text(by_name)
    page.get_by_role("button", name="List").click()
    heading = heads.get_by_role("button", name="Sort by: Length, ascending")
    expect(heading).to_have_attribute("aria-pressed", "true")
    heads.get_by_role("button", name="Sort by: Name").click()
    page.wait_for_url(re.compile("sort=name"))
    heads.get_by_role("button", name="Sort by: Name, ascending").click()
    page.wait_for_url(re.compile("sort=-name"))
    expect(page.get_by_role("row").locator("strong")).to_have_text(by_name[::-1])


@pytest.mark.slow
def test_a_range_and_all_are_selected_with_clips_that_were_never_in_sight(open_studio: Served, visit_of: Any) -> None:
    for number in range(130):
        open_studio.upload(f"clip_{number:03d}.bvh", walk(3, seed=number))
    page = visit_of(open_studio).open("/library?sort=name")
    cards = page.get_by_role("gridcell")
    expect(cards.first).to_contain_text("clip_000")
    cards.first.click(modifiers=["Control"])
    expect(page.get_by_role("toolbar", name="1 selected")).to_be_visible()
    page.get_by_role("button", name="Select all 130").click()
    expect(page.get_by_role("toolbar", name="130 selected")).to_be_visible()
    page.get_by_role("button", name="Clear selection").click()
    cards.first.click(modifiers=["Control"])
    cards.nth(3).click(modifiers=["Shift"])
    expect(page.get_by_role("toolbar", name="4 selected")).to_be_visible()
    expect(page.get_by_role("button", name="Select all 130")).to_be_visible()


def test_filters_of_a_narrow_screen_are_a_sheet_for_keys_too(page: Any) -> None:
    page.set_viewport_size({"width": 390, "height": 800})
    page.get_by_role("button", name="Filters", exact=True).press("Enter")
    sheet = page.get_by_role("dialog", name="Filters")
    bars = sheet.get_by_role("region", name="Length").locator(".histogram button:enabled")
    expect(bars).to_have_count(4)
    bars.nth(3).press("Enter")
    done = sheet.get_by_role("button", name="Show 1 clip")
    expect(done).to_be_visible()
    done.press("Enter")
    expect(sheet).to_have_count(0)
    button = page.get_by_role("button", name="Filters, 1 active")
    expect(button).to_be_focused()
    expect(page.get_by_role("gridcell")).to_have_count(1)
    assert button.bounding_box()["x"] + button.bounding_box()["width"] <= 390
    button.press("Enter")
    sheet.get_by_role("button", name="Clear all filters").press("Enter")
    page.keyboard.press("Escape")
    expect(page.get_by_role("gridcell")).to_have_count(4)


def test_folders_of_a_property_have_the_counts_of_the_library(open_studio: Served, visit_of: Any) -> None:
    for number in range(7):
        subject = "Ana" if number < 5 else "Bo: left"
        open_studio.upload(
            f"c{number}.bvh", walk(3, seed=number), property=f"subject={subject}", project=f"p{number % 2}"
        )
    page = visit_of(open_studio).open("/library?sort=name")
    page.get_by_label("Folders by").select_option("subject")
    folders = page.get_by_role("list", name="Folders").get_by_role("link")
    expect(folders).to_have_text([re.compile("Ana.*5 clips"), re.compile("Bo: left.*2 clips")])
    folders.first.press("ArrowDown")
    folders.nth(1).press("Enter")
    cards = page.get_by_role("gridcell")
    expect(cards).to_have_text([re.compile("c5"), re.compile("c6")])
    path = page.get_by_role("navigation", name="Folders")
    expect(path).to_contain_text("Bo: left")
    page.reload()
    expect(cards).to_have_count(2)
    path.get_by_role("link", name="subject").click()
    # Counts are those under the other filters.
    page.get_by_role("region", name="Project").get_by_role("button", name="p1").click()
    expect(folders).to_have_text([re.compile("Ana.*2 clips"), re.compile("Bo: left.*1 clip")])
    page.get_by_role("button", name="Show all clips without folders").click()
    expect(cards).to_have_count(3)


def test_a_saved_view_keeps_order_form_and_folders(page: Any, open_studio: Served, visit_of: Any) -> None:
    page.goto(f"{open_studio.url}/library?sort=-name&view=list&length=1..&folders=format")
    page.get_by_role("button", name="Save view").click()
    page.get_by_role("textbox", name="Name").fill("long by format")
    page.keyboard.press("Enter")
    saved = page.get_by_role("region", name="Saved views").get_by_role("button", name="long by format", exact=True)
    expect(saved).to_have_attribute("aria-pressed", "true")
    assert open_studio.get("/collections/long by format")["view"] == {
        "sort": "-name", "layout": "list", "folders": "format",
    }  # fmt: skip
    # Of another person, who looks at the library otherwise.
    other = visit_of(open_studio).open("/library?sort=name")
    other.get_by_role("button", name="long by format", exact=True).click()
    expect(other).to_have_url(re.compile(r"(?=.*sort=-name)(?=.*view=list)(?=.*folders=format)(?=.*length=1)"))
    other.get_by_role("button", name="Show all clips without folders").click()
    expect(other.get_by_role("row").locator("strong")).to_have_text(["of_3000", "of_300"])
    shown = other.get_by_role("region", name="Saved views").get_by_role("button", name="long by format", exact=True)
    expect(shown).to_have_attribute("aria-pressed", "false")
