"""Proposals in a real browser: a story from the invitation to the applied change, and the view of a viewer."""

from __future__ import annotations

import re
from typing import Any

import pytest

from mcml.formats import FORMATS
from mcml_service.demo.walks import turning_walk
from tests.web.conftest import Served, Visit
from tests.web.test_accounts import WORDS, closed, join
from tests.web.test_journeys import ready
from tests.web.test_stories import Hand

expect: Any = pytest.importorskip("playwright.sync_api").expect


def stored(page: Any, studio: Served, project: str = "gait") -> str:
    """The id of a clip that a signed-in person has stored."""
    content = b"".join(FORMATS["bvh"].write(turning_walk("walk", 174.0, 0.0, 2.0), "bvh"))
    files = {"name": "walk.bvh", "mimeType": "text/plain", "buffer": content}
    made = page.request.post(
        f"{studio.url}/api/v1/documents", multipart={"file": files, "project": project}, headers={"origin": studio.url}
    )
    return str(made.json()["documents"][0]["id"])


def revision(page: Any, studio: Served, document: str) -> int:
    return int(page.request.get(f"{studio.url}/api/v1/documents/{document}").json()["revision"])


@pytest.mark.slow
@closed
def test_a_lead_invites_and_reviews(visit: Visit, studio: Served) -> None:
    """Invite, propose, approve, apply: at most 12 clicks."""
    hand = Hand()
    with studio.database.write() as tx:
        link = tx.sessions.link("local")
    page = visit.open(f"/login?link={link}")
    join(page, "kim")
    document = stored(page, studio)
    page.goto(f"{studio.url}/settings/projects?project=gait")
    hand.press(page.get_by_label("Require a review of changes"))
    expect(page.get_by_text("Changes now need a review")).to_be_visible()
    hand.press(page.get_by_role("button", name="Invite"))
    address = page.locator(".account-secret code").inner_text()

    with page.context.browser.new_context(viewport={"width": 1280, "height": 800}) as other:
        second = other.new_page()
        second.goto(address)
        second.get_by_label("Name").fill("lee")
        second.get_by_label("Password").fill(WORDS)
        hand.press(second.get_by_role("button", name="Create account"))
        second.wait_for_url(lambda url: "/login" not in url)
        second.goto(f"{studio.url}/library")
        hand.press(second.get_by_role("gridcell", name=re.compile("walk")))
        ready(second)
        hand.press(second.get_by_role("toolbar", name="Play").get_by_role("button", name="Frames"))
        hand.press(second.get_by_role("menuitem", name="Mirror left and right"))
        dialog = second.get_by_role("dialog")
        expect(dialog.get_by_text("This project requires a review of changes.")).to_be_visible()
        expect(dialog.get_by_role("button", name="Apply")).to_have_count(0)
        dialog.get_by_label("Message (optional)").fill("Left and right were swapped")
        hand.press(dialog.get_by_role("button", name="Propose"))
        expect(second.get_by_text("Proposal 1 created for review")).to_be_visible()
        assert revision(page, studio, document) == 1

        page.goto(f"{studio.url}/clips/{document}")
        ready(page)
        hand.press(page.get_by_role("button", name="1 proposal"))
        expect(page.get_by_text("Left and right were swapped")).to_be_visible()
        difference = page.get_by_role("region", name="Difference")
        expect(difference.locator(".apart button").first).to_contain_text(re.compile(r"cm"))
        expect(page.get_by_role("button", name="Apply", exact=True)).to_be_disabled()
        hand.press(page.get_by_role("button", name="Approve"))
        hand.press(page.get_by_role("button", name="Apply", exact=True))
        expect(page.get_by_text("Proposal 1 applied as revision 2")).to_be_visible()
        assert revision(page, studio, document) == 2
    assert len(hand.clicks) <= 12, hand.clicks


@pytest.mark.slow
@closed
def test_a_viewer_proposes_and_comments(visit: Visit, studio: Served, visit_of: Any) -> None:
    """A viewer may only propose; a crop is compared by the frames that survive it; a comment leads to its frame."""
    with studio.database.write() as tx:
        link = tx.sessions.link("local")
    owner = visit.open(f"/login?link={link}")
    join(owner, "kim")
    document = stored(owner, studio)
    with studio.database.write() as tx:
        viewer = tx.accounts.add("vic", "member", "x")
        tx.members.put(tx.projects.get("gait"), "vic", "reader")
        secret = tx.tokens.add("vic's", owner=viewer)
    page = visit_of(Served(studio.url, studio.database, secret)).open(f"/clips/{document}?tab=proposals")
    ready(page)
    expect(page.get_by_text("No open proposals.")).to_be_visible()
    page.get_by_role("toolbar", name="Play").get_by_role("button", name="Frames").click()
    page.get_by_role("menuitem", name="Mirror left and right").click()
    expect(page.get_by_text("Viewers propose changes; editors apply them.")).to_be_visible()
    page.keyboard.press("Escape")
    page.keyboard.press("Home")
    for key in ("i", "End", "Shift+ArrowLeft", "o"):
        page.keyboard.press(key)
    page.get_by_role("toolbar", name="Play").get_by_role("button", name="Frames").click()
    page.get_by_role("menuitem", name=re.compile("^Trim to")).click()
    expect(page.get_by_text("Proposal 1 created for review")).to_be_visible()
    panel = page.get_by_role("tabpanel")
    expect(panel.get_by_text("Compared: 110 frames in both. Removed: 10, added: 0.")).to_be_visible()
    expect(panel.get_by_text("No joint moved.")).to_be_visible()
    expect(panel.get_by_role("button", name="Apply", exact=True)).to_have_count(0)
    for key in ("Backslash", "Home"):
        page.keyboard.press(key)
    panel.get_by_label("Comment. @name mentions a person").fill("too short")
    panel.get_by_role("button", name="Comment", exact=True).click()
    expect(panel.get_by_text("too short")).to_be_visible()

    page.goto(f"{studio.url}/clips/{document}?f=5&sel=left_up_leg")
    ready(page)
    tree = page.get_by_role("tree", name="Tree")
    tree.get_by_role("treeitem").filter(has_text=re.compile(r"^Rx")).dblclick()
    field = tree.get_by_role("textbox", name="Rx")
    field.fill("77.5")
    field.press("Enter")
    expect(page.get_by_text("Draft: 1 change")).to_be_visible()
    expect(page.get_by_role("button", name="Save", exact=True)).to_have_count(0)
    page.get_by_label("Message (optional)").fill("Bend the leg")
    page.get_by_role("button", name="Propose", exact=True).click()
    expect(page.get_by_text("Proposal 2 created for review")).to_be_visible()
    expect(page.get_by_text("Draft: 1 change")).to_have_count(0)
    expect(page.get_by_role("button", name="2 proposals")).to_be_visible()
    made = studio.get(f"/documents/{document}/proposals/2")
    assert (made["kind"], made["author"], made["message"], made["changes"]["frames"][0]["columns"]) == (
        "changes", "vic", "Bend the leg", ["left_up_leg.Rx"],
    )  # fmt: skip
    studio.client().post(f"/documents/{document}/proposals/2/close").raise_for_status()

    owner.goto(f"{studio.url}/clips/{document}?tab=proposals")
    ready(owner)
    expect(owner.get_by_text("too short")).to_be_visible()
    owner.keyboard.press("End")
    owner.get_by_role("tabpanel").get_by_role("button", name="Frame 1", exact=True).click()
    expect(owner.get_by_role("img", name=re.compile("frame 1 of 120", re.IGNORECASE)).first).to_be_visible()
    owner.get_by_role("tabpanel").get_by_role("button", name="Close", exact=True).click()
    expect(owner.get_by_text("No open proposals.")).to_be_visible()
    assert revision(owner, studio, document) == 1
