"""`mcml webhook add`: an address to which a server sends events."""

from __future__ import annotations

from typing import Annotated

import typer

from mcml_schemas.team.webhooks import WebhookRequest
from mcml_service.cli.terminal.opening import DatabaseOption, ServerOption, console, open_client
from mcml_service.cli.terminal.requests import request_of


def add(
    url: Annotated[str, typer.Argument(help="Where messages are sent, with https")],
    project: Annotated[str | None, typer.Option(help="Tell of this project alone")] = None,
    kind: Annotated[
        list[str] | None, typer.Option(help="Tell of this kind of events, such as comment; may be repeated")
    ] = None,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Add a webhook, to which a server sends events. The secret for its signatures is shown only once."""
    asked = request_of(WebhookRequest, {"url": url, "project": project, "kinds": kind or []})
    made = open_client(database, server).call("add_webhook", request=asked)
    print(made.secret)
    console.print(f"webhook {made.number}", style="dim")
