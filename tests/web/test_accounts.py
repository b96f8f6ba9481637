"""People in a browser: the first owner by the link of the terminal, an invitation, a role, a token, signing out."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.web.conftest import Served, Visit

expect: Any = pytest.importorskip("playwright.sync_api").expect

pytestmark = pytest.mark.parametrize("studio", ["session"], indirect=True)
WORDS = "four words in a row"


def join(page: Any, name: str) -> None:
    page.get_by_label("Name").fill(name)
    page.get_by_label("Password").fill(WORDS)
    page.get_by_role("button", name="Make the account").click()
    page.wait_for_url(lambda url: "/login" not in url)


def test_an_owner_invites_somebody_who_may_do_less(visit: Visit, studio: Served) -> None:
    with studio.database.write() as tx:
        link = tx.sessions.link("local")
    page = visit.open(f"/login?link={link}")
    join(page, "kim")
    page.goto(f"{studio.url}/settings")
    expect(page.get_by_text("You are kim, owner.")).to_be_visible()
    page.get_by_label("Role", exact=True).select_option("reader")
    page.get_by_role("button", name="Invite").click()
    address = page.locator(".account-secret code").inner_text()
    expect(page.get_by_role("cell", name="from kim")).to_be_visible()

    with page.context.browser.new_context() as other:
        second = other.new_page()
        second.goto(address)
        join(second, "lee")
        second.goto(f"{studio.url}/settings")
        expect(second.get_by_text("You are lee, reader.")).to_be_visible()
        expect(second.get_by_role("heading", name="People")).to_have_count(0)
        second.get_by_role("button", name="Make a token").click()
        second.get_by_role("dialog").get_by_label("Name").fill("render-farm")
        second.keyboard.press("Enter")
        token = second.locator(".account-secret code").inner_text()
        assert second.request.get(f"{studio.url}/api/v1/account", headers={"authorization": f"Bearer {token}"}).json()[
            "rights"
        ] == ["read"]
        page.reload()
        page.get_by_label("Role of lee").select_option("editor")
        expect(page.get_by_text("lee was changed")).to_be_visible()
        second.reload()
        expect(second.get_by_text("You are lee, editor.")).to_be_visible()
        second.get_by_role("button", name="Sign out").click()
        second.wait_for_url(re.compile("/login"))
        assert second.request.get(f"{studio.url}/api/v1/account").status == 401
