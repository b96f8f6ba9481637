"""Which documents there are, and which of them a question asks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from service.storage.columns import Listed
from service.storage.database import Transaction
from service.xpath.kept import Kept

STATES = 4
"""States of the store whose documents are kept: the present one, and some that pages or streams still read."""


@dataclass
class _State:
    """What was read of one state: all documents, once somebody asked for them, and single ones by key. keys: by id."""

    whole: list[Listed] | None = None
    documents: dict[int, Listed] = field(default_factory=dict)
    keys: dict[str, int] = field(default_factory=dict)


class Listing:
    """The documents of the store, read anew after each commit. Threads may share it."""

    def __init__(self) -> None:
        # By the newest commit as well as the one that is read: a deleted document that comes back was never away.
        self._states = Kept[tuple[int, int], _State](STATES, lambda _: 1)

    def documents(self, tx: Transaction, keys: Sequence[int] | None = None, project: int | None = None) -> list[Listed]:
        """The documents (all, if no keys are given) by name, then key."""
        state = self._state(tx)
        if keys is None:
            if state.whole is None:
                state.whole = tx.columns.documents()
                state.documents.update({listed.key: listed for listed in state.whole})
            found = state.whole
        else:
            missing = [key for key in keys if key not in state.documents]
            if missing and state.whole is None:
                state.documents.update({listed.key: listed for listed in tx.columns.documents(missing)})
            chosen = [state.documents[key] for key in dict.fromkeys(keys) if key in state.documents]
            found = sorted(chosen, key=lambda listed: (listed.name, listed.key))
        return found if project is None else [listed for listed in found if listed.project == project]

    def key(self, tx: Transaction, uuid: str) -> int:
        """The key of a document; NotFoundError."""
        keys = self._state(tx).keys
        if uuid not in keys:
            keys[uuid] = tx.documents.get(uuid).key
        return keys[uuid]

    def _state(self, tx: Transaction) -> _State:
        key = (tx.newest_commit(), tx.at)
        return self._states.get([key], lambda _: {key: _State()})[0]
