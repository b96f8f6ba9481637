"""Naming a stretch: what the project agreed on is offered first, in its colours."""

from __future__ import annotations

from typing import Any

import pytest

from tests.web.conftest import Served, Visit, one_door, walk
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = one_door


@pytest.mark.slow
def test_names_that_a_project_agreed_on_come_first(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("walk.bvh", walk(), project="gait")
    words = [{"name": "zigzag", "description": "to both sides", "colour": 5}, {"name": "amble"}]
    with studio.client() as client:
        label = {"name": "beginning", "first": 1, "last": 20}
        client.post(f"/documents/{uuid}/labels", json=[label], headers={"if-match": "*"}).raise_for_status()
        client.put("/vocabulary", params={"project": "gait"}, json={"items": words}).raise_for_status()
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.locator(".span", has_text="beginning").dblclick()
    form = page.get_by_role("form", name="Label")
    form.get_by_role("combobox").fill("")
    options = form.get_by_role("option")
    expect(options.nth(0)).to_have_text("zigzagto both sides")
    expect(options.nth(1)).to_have_text("amble")
    expect(options.nth(2)).to_have_text("beginning")
    options.nth(0).click()
    named = page.locator(".span", has_text="zigzag")
    expect(named).to_be_visible()
    # Its own text would give it the first of the eight.
    assert "--name5" in named.evaluate("span => span.style.cssText + span.parentElement.style.cssText")


def test_a_project_s_names_are_agreed_on_in_its_settings(visit: Visit, studio: Served) -> None:
    studio.upload("walk.bvh", walk(), project="gait")

    def kept() -> list[Any]:
        return list(studio.get("/vocabulary", project="gait")["items"])

    page = visit.open("/settings/projects?project=gait")
    for name, meaning in (("amble", ""), ("zigzag", "to both sides")):
        page.get_by_label("New label").fill(name)
        page.get_by_label("Description", exact=True).fill(meaning)
        with page.expect_response("**/vocabulary?project=gait"):
            page.get_by_role("form", name="Label vocabulary").get_by_role("button", name="Add").click()
        expect(page.get_by_label(f"Description of {name}")).to_have_value(meaning)

    def press_meanwhile(route: Any) -> None:
        page.get_by_role("button", name="Remove amble").click()
        route.continue_()

    # The second edit is made before the first one is answered.
    page.route("**/vocabulary?project=gait", press_meanwhile, times=1)
    page.get_by_label("Colour of zigzag").select_option("6")
    expect(page.get_by_label("Description of amble")).to_have_count(0)
    assert kept() == [{"name": "zigzag", "description": "to both sides", "colour": 5}]
    visit.wanted.add(422)
    page.get_by_label("New label").fill("knee-flexion")
    page.get_by_role("form", name="Label vocabulary").get_by_role("button", name="Add").click()
    expect(page.get_by_text("which side")).to_be_visible()
    expect(page.get_by_label("New label")).to_have_value("knee-flexion")
    page.get_by_role("button", name="Remove zigzag").click()
    expect(page.get_by_label("Description of zigzag")).to_have_count(0)
    assert kept() == []
