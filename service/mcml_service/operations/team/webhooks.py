"""Webhooks, which send events to other programs, and the log of sent messages."""

from __future__ import annotations

from typing import Annotated, Any
from urllib.parse import urlsplit

from pydantic import Field

from mcml.errors import RequestError
from mcml_schemas.team.webhooks import DeliveryPage, DeliveryView, WebhookList, WebhookMade, WebhookRequest, WebhookView
from mcml_service.operations.arguments import MOST, InProject, Page
from mcml_service.operations.call import Call
from mcml_service.storage.team.webhooks import Delivery, Webhook

Number = Annotated[int, Field(ge=1, le=MOST, description="Number of the webhook", examples=[2])]
Message = Annotated[int, Field(ge=1, le=MOST, description="Number of the message, as the log has it", examples=[31])]


def list_webhooks(call: Call, project: InProject = None) -> WebhookList:
    """Of projects that one owns; those of the whole repository for its owners."""
    with call.database.read() as tx:
        webhooks = tx.webhooks.all(None if project is None else tx.projects.get(project))
    return WebhookList(items=[WebhookView(**_describe(webhook)) for webhook in webhooks])


def add_webhook(call: Call, request: WebhookRequest) -> WebhookMade:
    """Messages have the form of Standard Webhooks, and are signed with the secret that is shown this once."""
    _check(request.url, private=call.settings.webhook_private)
    with call.database.write(call.author) as tx:
        key = None if request.project is None else tx.projects.get(request.project)
        secret, made = tx.webhooks.add(request.url, dict.fromkeys(request.kinds), key)
    return WebhookMade(**_describe(made), secret=secret)


def remove_webhook(call: Call, number: Number) -> None:
    """Its log goes, too."""
    with call.database.write(call.author) as tx:
        tx.webhooks.remove(number)


def list_deliveries(call: Call, number: Number, page: Page) -> DeliveryPage:
    """The newest first."""
    before = page.after(int)
    with call.database.read() as tx:
        tx.webhooks.get(number)
        deliveries = tx.webhooks.deliveries(number, None if before is None else before[0], page.most(call) + 1)
    shown, more = page.cut(call, deliveries, lambda delivery: (delivery.number,))
    return DeliveryPage(items=[_describe_delivery(delivery) for delivery in shown], next_cursor=more)


def redeliver(call: Call, number: Number, message: Message) -> DeliveryView:
    """A server sends it soon, with the id that it had."""
    with call.database.write(call.author) as tx:
        return _describe_delivery(tx.webhooks.send_again(number, message))


def _check(url: str, *, private: bool) -> None:
    """RequestError for an address that nothing is sent to."""
    # Imported here: other operations send nothing.
    from mcml_service.jobs.webhooks import addresses_of

    try:
        address = urlsplit(url)
        host, port, plain = address.hostname or "", address.port, address.scheme == "http" and private
        if (address.scheme != "https" and not plain) or "@" in address.netloc or address.fragment or not url.isascii():
            raise RequestError(
                "A webhook has an https address without a name, a password and a fragment.",
                remedy="Servers with MCML_WEBHOOK_PRIVATE=true take http, too.",
            )
        addresses_of(host, port or (80 if plain else 443), private=private)
    except (OSError, ValueError):
        # The answer does not reveal whether a name belongs to a private network.
        raise RequestError(
            "There is no such host on the internet.",
            remedy="Check the address. Hosts of private networks need MCML_WEBHOOK_PRIVATE=true on the server.",
        ) from None


def _describe(one: Webhook) -> dict[str, Any]:
    return {**vars(one), "kinds": list(one.kinds)}


def _describe_delivery(one: Delivery) -> DeliveryView:
    facts: dict[str, Any] = dict(vars(one))
    return DeliveryView(**facts)
