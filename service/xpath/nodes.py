"""What a query gives."""

from __future__ import annotations

from dataclasses import dataclass

from service.storage.columns import Listed


@dataclass(frozen=True, slots=True)
class Node:
    """A node of a result. value: an element as XML, else the text."""

    kind: str
    stored: Listed
    address: str
    value: str


@dataclass(frozen=True, slots=True)
class Run:
    """Frames first to last of a document."""

    stored: Listed
    first: int
    last: int
