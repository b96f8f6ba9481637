"""What keys reach, and in how many stops: pages that open, filters of the library, names that differ in their ends."""

from __future__ import annotations

from typing import Any

import pytest

from tests.builders import TRC
from tests.web.conftest import Served, Visit, open_door, walk
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = open_door
FEWEST_STOPS = 12


def at(page: Any, what: str) -> bool:
    return bool(page.evaluate("what => document.activeElement.matches(what)", what))


@pytest.mark.slow
def test_the_first_card_is_a_few_stops_away(visit: Visit, studio: Served) -> None:
    for n in range(12):
        studio.upload(f"walk_{n}.bvh", walk(30 + 20 * n), project=f"study {n}")
    studio.upload("still.trc", TRC)
    page = visit.open("/library")
    page.locator("[data-id]").nth(4).wait_for()
    expect(page.locator("main h1")).to_be_focused()
    stops = 0
    while not at(page, "[data-id]"):
        page.keyboard.press("Tab")
        stops += 1
        assert stops <= FEWEST_STOPS, page.evaluate("document.activeElement.outerHTML.slice(0, 200)")
    page.keyboard.press("Enter")
    page.wait_for_url("**/clips/*")


@pytest.mark.slow
def test_a_filter_is_one_stop_with_arrows_inside(visit: Visit, studio: Served) -> None:
    for n in range(3):
        studio.upload(f"walk_{n}.bvh", walk(30), project=f"study {n}")
    page = visit.open("/library")
    group = page.get_by_role("region", name="Project")
    items = group.get_by_role("button")
    expect(items).to_have_count(3)
    assert items.evaluate_all("all => all.filter(one => one.tabIndex === 0).length") == 1
    items.first.focus()
    page.keyboard.press("ArrowDown")
    expect(items.nth(1)).to_be_focused()
    page.keyboard.press("End")
    expect(items.nth(2)).to_be_focused()
    page.keyboard.press("ArrowDown")
    expect(items.nth(2)).to_be_focused()
    page.keyboard.press("Enter")
    expect(group.get_by_role("button", pressed=True)).to_be_focused()
    page.keyboard.press("Tab")
    assert not group.evaluate("box => box.contains(document.activeElement)")
    page.keyboard.press("Shift+Tab")
    expect(group.get_by_role("button", pressed=True)).to_be_focused()


@pytest.mark.slow
def test_nothing_sits_on_the_body_after_opening(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk(60))
    page = visit.open("/library")
    for path in ("/library", f"/clips/{uuid}", "/compose", "/retarget", "/analyses", "/settings", "/xpath"):
        page.goto(visit.url + path)
        page.wait_for_function("() => document.querySelector('main h1') && !document.querySelector('main .busy')")
        page.wait_for_function("() => document.activeElement !== document.body", timeout=5000)
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    expect(page.locator("main h1")).to_be_focused()


def test_long_names_keep_their_ends(visit: Visit, studio: Served) -> None:
    long = "dataset-1_walk-turn-left_masculinity_take_{:03}"
    for n in (1, 2):
        studio.upload(f"{long.format(n)}.bvh", walk(30))
    page = visit.open("/library")
    cards = page.locator("[data-id] strong")
    expect(cards).to_have_count(2)
    for card in cards.all():
        box = card.bounding_box()
        tail = card.locator(".middle-cut > :last-child").bounding_box()
        assert tail["x"] + tail["width"] <= box["x"] + box["width"] + 1, "its end is in sight"
        assert card.locator(".middle-cut").get_attribute("title") in {long.format(1), long.format(2)}
        head = card.locator(".middle-cut > :first-child")
        assert head.evaluate("one => one.scrollWidth > one.clientWidth"), "it is cut"
