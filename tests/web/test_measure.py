"""Many clips measured in the studio: from files to a table, with clicks counted; an address that shows it again."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.laboratory.walkers import Gait, events_of, make_c3d
from tests.motion.bodies.made import person
from tests.web.conftest import Served, walk

expect: Any = pytest.importorskip("playwright.sync_api").expect
MOST_CLICKS = 15
SVG = "{http://www.w3.org/2000/svg}"


def walkers(folder: Path) -> list[Path]:
    """Trials of a walker, the last with feet far apart."""
    files = []
    for number in range(6):
        gait = Gait(seconds=5, width=0.5 if number == 5 else 0.16 + 0.002 * number)
        files.append(folder / f"trial{number}.c3d")
        files[-1].write_bytes(make_c3d(gait, sorted(events_of(gait))))
    return files


@pytest.mark.slow
def test_files_become_a_gait_table_in_few_clicks(open_studio: Served, visit_of: Any, tmp_path: Path) -> None:
    clicks: list[str] = []

    def press(what: Any, **options: Any) -> None:
        clicks.append(str(what))
        what.click(**options)

    page = visit_of(open_studio).open("/library?sort=name")
    with page.expect_file_chooser() as chooser:
        press(page.locator(".toolbar .primary"))
    chooser.value.set_files(walkers(tmp_path))
    expect(page.locator(".tray tbody").get_by_role("link", name="Open")).to_have_count(6)
    press(page.locator(".tray header").get_by_role("button").last)
    cards = page.get_by_role("gridcell")
    expect(cards).to_have_text([re.compile(f"trial{number}") for number in range(6)])
    press(cards.nth(0), modifiers=["Control"])
    expect(page.get_by_role("toolbar", name="1 selected")).to_be_visible()
    press(cards.nth(5), modifiers=["Shift"])
    press(page.get_by_role("toolbar", name="6 selected").get_by_role("button", name="Measure"))
    press(page.get_by_role("button", name="Add gait angles"))
    page.get_by_role("combobox", name="Frame ranges").select_option("Strides of gait")
    clicks += ["open the list", "choose"]
    save = page.get_by_role("button", name="Download CSV")
    expect(save).to_be_enabled()
    expect(page.get_by_role("status").filter(has_text="rows of 6 clips")).to_be_visible()
    with page.expect_download() as download:
        press(save)
    assert len(clicks) <= MOST_CLICKS, clicks
    with Path(download.value.path()).open() as file:
        rows = list(csv.DictReader(file))
    assert {row["quantity"] for row in rows} >= {"angle:left-knee-flexion", "angle:right-knee-flexion"}
    assert {row["name"] for row in rows} == {f"trial{number}" for number in range(6)}
    knee = [row for row in rows if row["quantity"] == "angle:left-knee-flexion"]
    strides = [open_studio.get(f"/documents/{uuid}/gait")["strides"] for uuid in {row["document"] for row in rows}]
    assert len(knee) == sum(one["side"] == "left" and not one["rejected"] for own in strides for one in own)


@pytest.fixture
def measured(open_studio: Served, visit_of: Any) -> tuple[Any, str]:
    """The page with the hands of five people, and its address; and the odd one's name."""
    for seed in range(4):
        open_studio.upload(f"p{seed}.bvh", person(seed, 60), project="people", unit="cm")
    open_studio.upload("odd.bvh", person(9, 60, scale=3.0), project="people", unit="cm")
    address = "/measure?project=people&m=speed:left_hand%7Cspeed:right_hand"
    page = visit_of(open_studio).open(address)
    expect(page.get_by_role("status").filter(has_text="10 rows of 5 clips")).to_be_visible()
    return page, address


@pytest.mark.slow
def test_rows_and_curves_play_and_the_address_shows_them_again(
    open_studio: Served, measured: tuple[Any, str], visit_of: Any
) -> None:
    page, _ = measured
    plots = page.locator(".measure-plots svg")
    expect(plots).to_have_count(2)
    table = page.get_by_role("region", name="Table of frame ranges").get_by_role("table")
    first = table.get_by_role("row").nth(1)
    expect(first).to_contain_text("odd")
    expect(first).to_contain_text("Outlier")
    first.get_by_role("button").click()
    expect(page.locator(".run-player")).to_contain_text("odd")
    page.wait_for_url(re.compile(r"row="))
    page.get_by_role("button", name="Close player").click()
    expect(page.locator(".run-player")).to_have_count(0)
    answer = open_studio.client().post("/measure", json=REQUEST).json()
    row = next(one for one in answer["ranges"] if one["quantity"] == "speed:left_hand" and one["name"] == "p2")
    press_curve(page, answer, row)
    expect(page.locator(".run-player strong")).to_have_text("p2")
    page.wait_for_url(re.compile(rf"row={row['document']}"))
    again = visit_of(open_studio).open(page.url.removeprefix(open_studio.url))
    expect(again.locator(".run-player")).to_be_visible()
    expect(again.locator(".run-player strong")).to_have_text("p2")
    assert again.locator("tr.picked").inner_text() == page.locator("tr.picked").inner_text()


REQUEST = {"selection": {"project": "people"}, "quantities": ["speed:left_hand", "speed:right_hand"], "curves": True}


def press_curve(page: Any, answer: dict[str, Any], row: dict[str, Any]) -> None:
    """Click the curve of a row in the plot of its group, where it is farthest from the others."""
    group = next(one for one in answer["groups"] if one["quantity"] == row["quantity"])
    rows = [one for one in answer["ranges"] if one["quantity"] == row["quantity"]]
    curves = np.array([one["curve"] for one in rows], float)
    own = np.array(row["curve"], float)
    others = curves[[one is not row for one in rows]]
    at = int(np.abs(others - own).min(axis=0).argmax())
    mean, sd = (np.array(group[name], float) for name in ("mean_curve", "sd_curve"))
    low, high = min(curves.min(), (mean - sd).min()), max(curves.max(), (mean + sd).max())
    pad = (high - low) * 0.05
    low, high = low - pad, high + pad
    plot = page.locator(".measure-plots svg").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    scale = box["width"] / 300
    x = 44 + at / 100 * (300 - 44 - 14)
    y = 170 - 32 - (own[at] - low) / (high - low) * (170 - 8 - 32)
    page.mouse.click(box["x"] + x * scale, box["y"] + y * scale)


@pytest.mark.slow
def test_plots_and_arrays_are_downloaded(measured: tuple[Any, str]) -> None:
    page, _ = measured

    def saved(name: str) -> Path:
        with page.expect_download() as download:
            page.get_by_role("button", name=name).click()
        return Path(download.value.path())

    arrays = np.load(saved("Download NPZ"))
    assert arrays["curves"].shape == (10, 101)
    picture = ElementTree.parse(saved("Download SVG")).getroot()
    assert picture.tag == f"{SVG}svg"
    assert len(picture.findall(f"{SVG}svg")) == 2
    texts = [text.text for text in picture.findall(f"{SVG}text")]
    assert any(text is not None and "left hand" in text for text in texts)


@pytest.mark.slow
def test_measurements_are_chosen_and_removed(measured: tuple[Any, str]) -> None:
    page, _ = measured
    page.get_by_role("button", name="Remove Speed: left hand").click()
    expect(page.get_by_role("status").filter(has_text="5 rows of 5 clips")).to_be_visible()
    page.get_by_label("Measurement", exact=True).select_option("Height")
    page.get_by_label("Joints", exact=True).select_option("left_foot")
    page.get_by_role("button", name="Add both sides").click()
    expect(page.get_by_role("status").filter(has_text="15 rows of 5 clips")).to_be_visible()
    page.get_by_label("Group by").select_option("Side and clip")
    expect(page.locator(".measure-plots figure")).to_have_count(15)
    page.get_by_role("combobox", name="Frame ranges").select_option("Results of a query")
    page.get_by_label("XPath query").fill("//frame[@id = '3']")
    page.keyboard.press("Tab")
    expect(page.get_by_role("cell", name="3–3", exact=True)).to_have_count(15)


def test_an_empty_page_leads_on(open_studio: Served, visit_of: Any) -> None:
    open_studio.upload("walk.bvh", walk())
    page = visit_of(open_studio).open("/measure")
    expect(page.get_by_text("Choose clips, then add a measurement.")).to_be_visible()
    expect(page.get_by_role("link", name="Gait parameters")).to_be_visible()
    page.get_by_role("link", name="Show analyses and results").click()
    page.wait_for_url("**/analyses")
    expect(page.get_by_role("link", name="Beats and bars")).to_be_visible()
    expect(page.get_by_role("link", name="Measure")).to_have_attribute("aria-current", "page")
