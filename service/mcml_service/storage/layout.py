"""The layout of a store, recorded in the store: values on which the store and the program must agree."""

from __future__ import annotations

from typing import Any

from sqlalchemy import inspect, select

from mcml.errors import StoreError
from mcml.motion.skeleton import CHANNELS
from mcml_service.storage.core import tables
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.core.statements import Statements
from mcml_service.storage.documents.encoding import PCODEC

LAYOUT = {"frames in a track": str(CHUNK), "channels": " ".join(CHANNELS), "codec": f"pcodec {PCODEC}"}


def require_layout(store: Statements) -> None:
    """StoreError where tracks are not as this program writes them."""
    held: dict[str, Any] = {}
    if inspect(store.connection).has_table(tables.store.name):
        held = dict(tuple(row) for row in store.fetch_all(select(tables.store.c.name, tables.store.c.value)))
    for name, value in LAYOUT.items():
        if held.get(name) != value:
            raise StoreError(
                f"The store's {name}: {held.get(name, 'not said')}; this program's: {value}.",
                remedy="Open the store with the program that made it, export its documents, and import them here.",
            )


def is_readable(layout: object) -> bool:
    """Whether tracks of that layout are read as they are: this one, or that of a program that knew fewer channels."""
    if not isinstance(layout, dict) or not isinstance(layout.get("channels"), str):
        return False
    channels = f"{layout['channels']} "
    return f"{LAYOUT['channels']} ".startswith(channels) and layout | {"channels": LAYOUT["channels"]} == LAYOUT


def refuse_newer(found: str | None, wanted: str | None) -> None:
    """StoreError where a newer program made or upgraded the store."""
    if found is not None and wanted is not None and found > wanted:
        raise StoreError(
            f"The store is newer than this program: its schema is {found}, this program knows {wanted}.",
            remedy="Update the program.",
        )
