"""Two people at one clip: each sees the other, and who changes it is named. Alone nothing is sent."""

from __future__ import annotations

from typing import Any

import pytest

from tests.web.conftest import Served, Visit, walk
from tests.web.test_journeys import ready

expect: Any = pytest.importorskip("playwright.sync_api").expect


@pytest.mark.slow
@pytest.mark.parametrize("studio", ["session"], indirect=True)
def test_two_people_see_each_other(visit_of: Any, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk())
    pages = {}
    with studio.database.write() as tx:
        tx.accounts.add("boss", "owner", "x")
    for name in ("kim", "Sam Lee"):
        visit: Visit = visit_of(studio)
        with studio.database.write() as tx:
            secret = tx.sessions.open_for(tx.accounts.add(name, "editor", "x"))
        visit.page.context.add_cookies([{"name": "mcml_session", "value": secret, "url": studio.url}])
        pages[name] = visit.open(f"/clips/{uuid}?f=5&sel=left_up_leg&tab=graph")
        ready(pages[name])
    kim, sam = pages.values()
    expect(sam.get_by_role("img", name="kim has been viewing this clip")).to_have_text("KI")

    field = sam.get_by_role("group", name="Value at frame 5").get_by_label("Rx")
    expect(field).not_to_have_value("")
    with sam.expect_response(lambda answer: answer.url.endswith("/presence") and "editing" in answer.request.post_data):
        field.fill("33.25")
        field.press("Enter")
    # Somebody who comes back to the page asks at once.
    kim.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    expect(kim.get_by_role("img", name="Sam Lee has been editing this clip")).to_have_text("SL")
    expect(kim.get_by_text("Sam Lee is editing this clip; saving merges")).to_be_visible()
    with sam.expect_response(lambda answer: answer.request.method == "DELETE"):
        sam.locator(".rail").get_by_role("link", name="Library").click()
    kim.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    expect(kim.get_by_role("list", name="Other people who have this clip open")).to_have_count(0)
    expect(kim.get_by_text("is editing this clip")).to_have_count(0)


@pytest.mark.slow
@pytest.mark.parametrize("studio", ["open"], indirect=True)
def test_alone_nothing_is_sent(visit: Visit, studio: Served) -> None:
    uuid = studio.upload("kick.bvh", walk())
    asked: list[str] = []
    visit.page.on("request", lambda request: asked.append(request.url))
    page = visit.open(f"/clips/{uuid}")
    with page.expect_response(lambda answer: answer.url.endswith("/account")):
        ready(page)
    page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    page.evaluate("() => new Promise(done => requestIdleCallback(done))")
    assert asked
    assert not any(url.endswith("/presence") for url in asked)
