"""The report of `mcml doctor` on documents that the current version would read differently."""

from __future__ import annotations

import time

from mcml_service.actions.keeping.find_differing import look_for_differing
from mcml_service.cli.terminal.opening import console
from mcml_service.storage.database import Database

MOST_SHOWN = 20
SECONDS = 60.0
"""For so long documents are looked at; a project at a time, more of a large store."""


def tell_differing(database: Database, project: str | None, count: int) -> None:
    """Print them, the first ones with the command that fixes each. count: number of documents."""
    end = time.monotonic() + SECONDS
    looked = told = found = 0
    unread: list[str] = []
    for looked_at in look_for_differing(database, project, lambda: time.monotonic() < end):
        looked += 1
        unread += [looked_at.unread] if looked_at.unread else []
        found += bool(looked_at.found)
        for item in looked_at.found:
            if told < MOST_SHOWN:
                console.print(f"NOTE {item.name} ({item.id}): {item.what}\n     {item.remedy}")
            told += 1
    if told > MOST_SHOWN:
        console.print(f"NOTE and {told - MOST_SHOWN:,} more")
    console.print(
        f"{'NOTE' if found else 'ok  '} interpretation   of {looked:,} documents {found:,} would differ today"
    )
    for fault in unread[:MOST_SHOWN]:
        console.print(f"     not looked at: {fault}")
    if looked < count:
        rest = f"{count - looked:,} were not looked at within {SECONDS:g} s"
        console.print(f"     {rest}: mcml doctor --project NAME looks at one project")
