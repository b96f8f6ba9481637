"""Find by example in a real browser: hits beside the viewer, and what is done with them, with clicks counted."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.motion.bodies.made import person
from tests.web.conftest import Served, Visit, one_door
from tests.web.test_journeys import ready
from tests.web.test_pages import faults

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = one_door


def counting(page: Any) -> None:
    page.evaluate("() => { window.clicks = 0; addEventListener('click', e => e.isTrusted && window.clicks++, true); }")


def clicks(page: Any) -> int:
    return int(page.evaluate("window.clicks"))


def panel(page: Any) -> Any:
    return page.get_by_role("complementary", name=re.compile("like frame"))


def hits_of(panel: Any) -> Any:
    return panel.get_by_role("list", name="Hits").get_by_role("link")


def found(studio: Served, uuid: str, **asked: Any) -> list[dict[str, Any]]:
    with studio.client() as client:
        answer = client.post("/search", json={"document": uuid, "limit": 120, **asked})
        return list(answer.json()["hits"])


@pytest.mark.slow
def test_hits_are_beside_the_viewer_and_stay_from_clip_to_clip(visit: Visit, studio: Served) -> None:
    uuid, other = studio.upload("kick.bvh", person(1, 120)), studio.upload("again.bvh", person(2, 120))
    page = visit.open(f"/clips/{uuid}?f=30&in=10&out=40")
    ready(page)
    counting(page)
    page.get_by_role("button", name="Find similar").click()
    beside = panel(page)
    expect(beside).to_have_accessible_name("Motions like frames 10–40 of kick")
    expect(beside.get_by_role("heading")).to_be_focused()
    page.wait_for_url(re.compile("like=10-40"))
    asked = found(studio, uuid, first=10, last=40)
    slider = beside.get_by_role("slider", name="Distance up to")
    slider.fill(str(slider.get_attribute("max")))
    expect(beside.get_by_role("status")).to_have_text(f"{len(asked)} hits")
    expect(hits_of(beside)).to_have_count(min(12, len(asked)))
    expect(hits_of(beside).first).to_have_text(re.compile("kick.*10–40.*0.000"))
    # Each picture moves: what it shows is not what it showed.
    page.wait_for_function(
        """() => {
          const now = [...document.querySelectorAll('.hit canvas')].map(one => one.toDataURL());
          window.seen ??= now.map(() => new Set());
          now.forEach((one, at) => window.seen[at]?.add(one));
          return window.seen.length && window.seen.every(one => one.size > 3);
        }"""
    )
    place = next(at for at, one in enumerate(asked[:12]) if one["document"] == other)
    hits_of(beside).nth(place).click()
    page.wait_for_url(re.compile(rf"/clips/{other}\?.*likeof={uuid}"))
    expect(page.get_by_role("heading", name="again", exact=True, include_hidden=True).first).to_be_attached()
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    assert clicks(page) == 2, "find, play"
    expect(panel(page)).to_have_accessible_name("Motions like frames 10–40 of kick")
    expect(hits_of(panel(page)).nth(place)).to_have_attribute("aria-current", "true")
    panel(page).get_by_role("button", name="Close").click()
    expect(panel(page)).to_have_count(0)
    page.wait_for_function("() => !location.search.includes('like')")


@pytest.mark.slow
def test_the_cut_and_the_scope_are_in_the_address(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", person(1, 120))
    studio.upload("far.bvh", person(1, 120), project="elsewhere")
    asked = found(studio, uuid, first=30)
    cut = asked[2]["distance"] + 1e-6
    page = visit.open(f"/clips/{uuid}?like=30&likemax={cut}&likein=project")
    ready(page)
    beside = panel(page)
    expect(beside).to_have_accessible_name("Poses like frame 30 of kick")
    expect(beside.get_by_role("button", name="This project")).to_have_attribute("aria-pressed", "true")
    expect(hits_of(beside).first).to_be_visible()
    names = hits_of(beside).evaluate_all("all => all.map(one => one.title)")
    assert set(names) == {"kick"}
    beside.get_by_role("button", name="Whole library").click()
    expect(hits_of(beside)).to_have_count(sum(one["distance"] <= cut for one in asked))
    expect(hits_of(beside).filter(has_text="far").first).to_be_visible()
    page.wait_for_function("() => !location.search.includes('likein')")
    assert faults(page) == []


@pytest.mark.slow
def test_all_hits_are_labelled_at_once_and_taken_back(visit: Visit, studio: Served) -> None:
    uuid, other = studio.upload("kick.bvh", person(1, 120)), studio.upload("twin.bvh", person(1, 120))
    page = visit.open(f"/clips/{uuid}?in=10&out=40")
    ready(page)
    counting(page)
    page.get_by_role("button", name="Find similar").click()
    beside = panel(page)
    hits = [one for one in found(studio, uuid, first=10, last=40) if one["distance"] <= 0.1]
    assert {one["document"] for one in hits} == {uuid, other}
    beside.get_by_role("button", name=re.compile("^Label ")).click()
    page.get_by_role("textbox", name="Label").or_(page.get_by_role("combobox", name="Label")).fill('kick, "left"')
    page.get_by_role("dialog").get_by_role("button", name="Label", exact=True).click()
    expect(page.get_by_text(f'Labelled {len(hits)} frame ranges kick, "left"')).to_be_visible()
    assert clicks(page) == 3, "find, label all, the name's button"
    for document in (uuid, other):
        labels = studio.get(f"/documents/{document}/labels")["items"]
        wanted = sorted((one["first"], one["last"]) for one in hits if one["document"] == document)
        assert sorted((one["first"], one["last"]) for one in labels) == wanted
        assert {one["name"] for one in labels} == {'kick, "left"'}
    page.get_by_role("button", name="Undo", exact=True).last.click()
    expect(page.get_by_text("revision 3", exact=True)).to_be_visible()
    page.wait_for_function(
        f"async () => !(await (await fetch('/api/v1/documents/{other}/labels')).json()).items.length"
    )
    assert studio.get(f"/documents/{uuid}/labels")["items"] == []


@pytest.mark.slow
def test_hits_are_collected_composed_and_exported(visit: Visit, studio: Served) -> None:
    uuid, other = studio.upload("kick.bvh", person(1, 120)), studio.upload("twin.bvh", person(1, 120))
    hits = [one for one in found(studio, uuid, first=10, last=40) if one["distance"] <= 0.1]
    page = visit.open(f"/clips/{uuid}?like=10-40")
    ready(page)
    beside = panel(page)
    beside.get_by_role("button", name="Collect").click()
    page.get_by_role("textbox", name="Name").fill("kicks")
    page.keyboard.press("Enter")
    expect(page.get_by_role("dialog")).to_have_count(0)
    kept = studio.get("/collections/kicks")
    assert set(kept["documents"]) == {uuid, other}
    beside.get_by_role("button", name="Export").click()
    with page.expect_download() as saved:
        page.get_by_role("menuitem", name=re.compile("BVH")).first.click()
    assert saved.value.suggested_filename.endswith(".zip")
    beside.get_by_role("button", name="Compose").click()
    page.wait_for_url(re.compile("/compose"))
    ranges = ",".join(f"{one['document']}:{one['first']}-{one['last']}" for one in hits)
    assert f"s={ranges}" in page.url.replace("%3A", ":").replace("%2C", ",")


@pytest.mark.slow
def test_a_label_and_a_brushed_range_are_examples(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", person(1, 120))
    with studio.client() as client:
        label = [{"name": "kick", "first": 21, "last": 60}]
        client.post(f"/documents/{uuid}/labels", json=label, headers={"if-match": "*"}).raise_for_status()
    page = visit.open(f"/clips/{uuid}")
    ready(page)
    page.get_by_role("button", name="kick, 21–60").dblclick()
    form = page.get_by_role("form", name="Label")
    form.get_by_role("button", name="Find similar").click()
    expect(panel(page)).to_have_accessible_name("Motions like frames 21–60 of kick")
    expect(form).to_have_count(0)
    box = page.get_by_role("list", name="Labels").bounding_box()
    y = box["y"] + box["height"] - 6
    page.mouse.move(box["x"] + box["width"] * 0.7, y)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.9, y, steps=4)
    page.mouse.up()
    first, last = (form.get_by_role("spinbutton").nth(at).input_value() for at in (0, 1))
    assert 60 < int(first) < int(last)
    form.get_by_role("button", name="Find similar").click()
    expect(panel(page)).to_have_accessible_name(f"Motions like frames {first}–{last} of kick")
