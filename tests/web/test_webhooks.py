"""Webhooks in the studio: made, with a secret that is shown once; their log, a message sent again; deleted."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mcml_service.jobs.webhooks import Sender
from tests.web.conftest import Served, serve

expect: Any = pytest.importorskip("playwright.sync_api").expect

NOBODY = "http://127.0.0.1:9/hook"


@pytest.fixture
def sending(sqlite_template: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    """A server that sends to its own machine, too."""
    monkeypatch.setenv("MCML_WEBHOOK_PRIVATE", "true")
    yield from serve(sqlite_template, tmp_path, closed=True)


@pytest.mark.slow
def test_an_address_is_told_and_its_log_is_read(sending: Served, visit_of: Any) -> None:
    visit = visit_of(sending)
    visit.wanted.add(422)
    page = visit.open("/settings/webhooks")
    page.get_by_label("URL").fill("ftp://files.example/")
    page.get_by_role("button", name="Add webhook", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("A webhook has an https address")
    page.get_by_label("URL").fill(NOBODY)
    page.get_by_label("webhooks").check()
    page.get_by_role("button", name="Add webhook", exact=True).click()
    expect(page.locator(".account-secret code")).to_contain_text("whsec_")
    hook = page.locator(".hooks > li", has_text=NOBODY)
    expect(hook).to_contain_text("all projects · webhooks")
    page.reload()
    expect(hook).to_be_visible()
    expect(page.get_by_text("whsec_")).to_have_count(0)

    Sender(sending.database, private=True).send_due()
    hook.get_by_role("button", name="Delivery log").click()
    message = hook.get_by_role("listitem").filter(has_text="webhook.add")
    expect(message).to_contain_text("waiting")
    message.get_by_role("button", name="Resend").click()
    expect(page.get_by_text("Queued for resending")).to_be_visible()

    hook.get_by_role("button", name="Delete").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(page.get_by_text("No webhooks yet.")).to_be_visible()
    assert sending.get("/webhooks")["items"] == []


def test_who_owns_nothing_has_no_webhooks(sending: Served, visit_of: Any) -> None:
    with sending.database.write("test") as tx:
        sending.token = tx.tokens.add("editor", scope="edit")
    page = visit_of(sending).open("/settings/webhooks")
    expect(page.get_by_text("Only owners of the project can add webhooks.")).to_be_visible()
    expect(page.get_by_label("URL")).to_have_count(0)
    page.goto(f"{sending.url}/settings/activity")
    expect(page.get_by_role("link", name="Projects")).to_be_visible()
    expect(page.get_by_role("link", name="Webhooks")).to_have_count(0)
