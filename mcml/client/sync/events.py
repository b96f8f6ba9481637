"""The results of a sync, file by file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from mcml.errors import AccessError, BusyError, McmlError, RequestError, StoreError

Action: TypeAlias = Literal["stored", "skipped", "replaced", "fetched", "waiting", "gone", "left", "conflict", "failed"]
"""stored: as a new document. skipped: its clip was in the repository already. replaced: the frames of its document.
fetched: written into the folder. waiting: somebody is writing it. gone: only its document is left. left: its document
is deleted or in another project. conflict: file and document changed."""

ENDING = (AccessError, BusyError, RequestError, StoreError)
"""Errors of the repository or of the options, not of a file: they end a round."""
REFUSED = frozenset({"conflict", "failed"})
DONE = frozenset({"stored", "replaced", "fetched"})


@dataclass(frozen=True)
class Event:
    """The result for one file. detail: the reason. remedy: what to do."""

    action: Action
    path: str
    document: str | None = None
    revision: int | None = None
    detail: str = ""
    remedy: str = ""

    @classmethod
    def of_error(cls, action: Action, path: str, error: McmlError, document: str | None = None) -> Event:
        place = f"line {error.at.line}: " if error.at is not None and error.at.line else ""
        return cls(action, path, document, detail=f"{place}{error.what}", remedy=error.remedy or "")
