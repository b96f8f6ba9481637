"""People in a browser: the first owner by the link of the terminal, an invitation, a role, a token, signing out."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.builders import bvh
from tests.web.conftest import Served, Visit

expect: Any = pytest.importorskip("playwright.sync_api").expect

closed = pytest.mark.parametrize("studio", ["session"], indirect=True)
WORDS = "four words in a row"


def join(page: Any, name: str) -> None:
    page.get_by_label("Name").fill(name)
    page.get_by_label("Password").fill(WORDS)
    page.get_by_role("button", name="Create account").click()
    page.wait_for_url(lambda url: "/login" not in url)


@pytest.mark.slow
@closed
def test_an_owner_invites_somebody_who_may_do_less(visit: Visit, studio: Served) -> None:
    with studio.database.write() as tx:
        link = tx.sessions.link("local")
    page = visit.open(f"/login?link={link}")
    join(page, "kim")
    page.goto(f"{studio.url}/settings")
    expect(page.get_by_text("Signed in as kim (owner).")).to_be_visible()
    page.get_by_label("Role", exact=True).select_option("reader")
    page.get_by_role("button", name="Invite").click()
    address = page.locator(".account-secret code").inner_text()
    expect(page.get_by_role("cell", name="by kim")).to_be_visible()

    with page.context.browser.new_context() as other:
        second = other.new_page()
        second.goto(address)
        join(second, "lee")
        second.goto(f"{studio.url}/settings")
        expect(second.get_by_text("Signed in as lee (reader).")).to_be_visible()
        expect(second.get_by_role("heading", name="People")).to_have_count(0)
        second.get_by_role("button", name="Create token").click()
        second.get_by_role("dialog").get_by_label("Name").fill("render-farm")
        second.keyboard.press("Enter")
        token = second.locator(".account-secret code").inner_text()
        assert second.request.get(f"{studio.url}/api/v1/account", headers={"authorization": f"Bearer {token}"}).json()[
            "rights"
        ] == ["read"]
        page.reload()
        page.get_by_label("Role of lee").select_option("editor")
        expect(page.get_by_text("lee updated")).to_be_visible()
        second.reload()
        expect(second.get_by_text("Signed in as lee (editor).")).to_be_visible()
        second.get_by_role("button", name="Sign out").click()
        second.wait_for_url(re.compile("/login"))
        assert second.request.get(f"{studio.url}/api/v1/account").status == 401


@pytest.mark.slow
@closed
def test_a_project_gets_a_member_and_a_clip_a_link(visit: Visit, studio: Served) -> None:
    """An owner lets somebody into one project, who sees nothing else; and gives away a link that plays one clip."""
    with studio.database.write() as tx:
        link = tx.sessions.link("local")
    page = visit.open(f"/login?link={link}")
    join(page, "kim")
    with studio.database.write() as tx:
        tx.accounts.add("lee", "member", "x")
    files = {"name": "walk.bvh", "mimeType": "text/plain", "buffer": bvh(60)}
    sent = {"origin": studio.url}
    made = page.request.post(
        f"{studio.url}/api/v1/documents", multipart={"file": files, "project": "gait"}, headers=sent
    )
    document = made.json()["documents"][0]["id"]
    page.goto(f"{studio.url}/settings/projects?project=gait")
    # The list is above the form, which moves down when it is there.
    expect(page.get_by_text("in all projects")).to_be_visible()
    page.get_by_label("Account name").fill("lee")
    page.get_by_role("form", name="Members").get_by_role("button", name="Add").click()
    role = page.locator("section", has=page.get_by_role("heading", name="Members")).get_by_label("Role of lee")
    expect(role).to_have_value("editor")
    role.select_option("reader")
    expect(page.get_by_text("lee updated").last).to_be_visible()

    page.goto(f"{studio.url}/clips/{document}")
    page.get_by_role("button", name="Share").click()
    page.get_by_role("menuitem", name="Share link").click()
    page.get_by_label("Label", exact=True).fill("the client")
    page.get_by_label("BVH").check()
    page.get_by_role("button", name="Create link").click()
    address = page.locator(".share-link").inner_text()

    with page.context.browser.new_context() as other:
        guest = other.new_page()
        asked: list[str] = []
        guest.on("request", lambda request: asked.append(request.url))
        guest.goto(address)
        expect(guest.get_by_role("heading", name="walk")).to_be_visible()
        expect(guest.get_by_role("img", name="walk")).to_be_visible()
        guest.wait_for_function("() => document.querySelector('.transport [role=slider]')?.ariaValueNow > 1")
        secret = address.partition("#")[2]
        assert asked
        assert not any(secret in url for url in asked)
        guest.get_by_role("button", name="Download as").click()
        with guest.expect_download() as saved:
            guest.get_by_role("menuitem", name="BVH").click()
        assert saved.value.suggested_filename == "walk.bvh"
        assert guest.request.get(f"{studio.url}/api/v1/documents").status == 401

        page.goto(f"{studio.url}/settings/projects?project=gait")
        links = page.locator("section", has=page.get_by_role("heading", name="Share links"))
        expect(links.get_by_text("the client")).to_be_visible()
        links.get_by_role("button", name="Revoke").click()
        expect(links).to_have_count(0)
        guest.reload()
        expect(guest.get_by_text("This link has expired or was revoked.")).to_be_visible()


@pytest.mark.slow
def test_the_first_step_on_a_fresh_server_is_an_own_account(visit_of: Any, open_studio: Served) -> None:
    """Nothing that closes the store is offered before, and whoever makes the account stays in."""
    open_studio.upload("walk.bvh", bvh(5), project="gait")
    visit: Visit = visit_of(open_studio)
    page = visit.open("/settings/projects?project=gait")
    expect(page.get_by_role("button", name="Invite to project")).to_have_count(0)
    page.get_by_role("link", name="Create account").click()
    first = page.get_by_role("region", name="Create your account first")
    expect(first).to_be_visible()
    for name in ("Invite", "Create token"):
        expect(page.get_by_role("button", name=name, exact=True)).to_have_count(0)
    visit.wanted = {422}
    first.get_by_label("Name").fill("local")
    first.get_by_label("Password").fill(WORDS)
    first.get_by_role("button", name="Create account").click()
    expect(first.get_by_role("alert")).to_contain_text("needs a name of its own")
    first.get_by_label("Name").fill("kim")
    first.get_by_role("button", name="Create account").click()
    expect(page.get_by_text("Signed in as kim (owner).")).to_be_visible()
    page.get_by_role("button", name="Invite").click()
    address = page.locator(".account-secret code").inner_text()
    with page.context.browser.new_context() as other:
        friend = other.new_page()
        friend.goto(address)
        join(friend, "lee")
        friend.goto(f"{open_studio.url}/settings")
        expect(friend.get_by_text("Signed in as lee (editor).")).to_be_visible()
    page.reload()
    expect(page.get_by_text("Signed in as kim (owner).")).to_be_visible()
    expect(page.get_by_label("Role of lee")).to_have_value("editor")
