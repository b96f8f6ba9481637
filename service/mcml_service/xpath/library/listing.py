"""The list of documents, and the documents of a query."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.hints import Kind, compared_names, not_found
from mcml_service.xpath.language.tree import Expression
from mcml_service.xpath.library import groups, listing_columns
from mcml_service.xpath.library.cache import Cache
from mcml_service.xpath.library.disk.sidecar import Sidecar
from mcml_service.xpath.library.groups import FEW_DOCUMENTS, VIEWS, Group, Groups

STATES = 4
"""States of the store whose documents are kept: the present one, and some that pages or streams still read."""

FEW = 100
"""Commits, after which what changed is read in a few milliseconds."""

Projects: TypeAlias = frozenset[int]
"""By their keys."""

LISTING = b"", "documents"
"""The part beside the store that has them."""

KNOWN_NAMES = 10_000
"""Texts for which it is kept whether names equal them."""


@dataclass
class State:
    """The state of the store at a commit, as far as it was read.

    commit: the commit. whole: all documents, once they were needed; whole_since: the commit since which the history was
    complete. documents: single ones by key. groups: of projects (None: of all) by their keys. keys: by id. unused:
    names in comparisons that do not occur, by scope.
    """

    commit: int
    whole: list[Listed] | None = None
    whole_since: int = 0
    groups: dict[Projects | None, list[Group]] = field(default_factory=dict)
    documents: dict[int, Listed] = field(default_factory=dict)
    keys: dict[str, int] = field(default_factory=dict)
    unused: dict[tuple[Kind, str, tuple[int, ...] | None, Projects | None], str | None] = field(default_factory=dict)

    def views(self) -> list[list[Group]]:
        """All choices of projects."""
        return list(self.groups.values())


class Listing:
    """The documents of the store; after a commit the changed ones are read again. Threads may share it."""

    def __init__(
        self, sidecar: Sidecar | None = None, on_change: Callable[[set[Group]], None] = lambda groups: None
    ) -> None:
        """sidecar: the cache of the documents on disk.

        on_change: called with the remaining groups when another state of the store is used: data of other groups is
        removed.
        """
        self._sidecar = sidecar
        self._on_change = on_change
        # By the newest commit as well as the one that is read: a deleted document that comes back was never away.
        self._states = Cache[tuple[int, int], State](STATES, lambda _: 1)
        self._groups = Groups()
        self._last: State | None = None
        self._written = -FEW

    def state(self, tx: Transaction) -> State:
        """Return the state that a transaction sees."""
        newest = tx.newest_commit()
        key = newest, tx.at
        if not self._states.holds([key]):
            states = self._states.values()
            self._on_change(self._groups.forget(one for state in states for of in state.views() for one in of))
        return self._states.get([key], lambda keys: {keys[0]: State(min(newest, tx.at))})[0]

    def whole(self, tx: Transaction, state: State) -> list[Listed]:
        """All documents by name, then key, the order of answers."""
        if state.whole is None:
            last = self._last
            # Changes since another state are known only for the newest state; purged documents leave no trace.
            is_newest, state.whole_since = tx.at >= tx.newest_commit(), tx.pruning.whole_since()
            if last is None and is_newest:
                last = self._kept(tx)
            is_known = last is not None and last.commit <= state.commit and last.whole_since == state.whole_since
            if is_newest and is_known and last is not None and last.whole is not None:
                state.whole = _changed(tx, last.whole, last.commit)
            else:
                state.whole = tx.columns.documents()
            if is_newest:
                self._keep(tx, state)
            state.documents.update({listed.key: listed for listed in state.whole})
            if is_newest and (last is None or last.commit <= state.commit):
                self._last = state
        return state.whole

    def _kept(self, tx: Transaction) -> State | None:
        """Return the state stored by another process."""
        found = None if self._sidecar is None else self._sidecar.read(tx, LISTING)
        if found is None:
            return None
        columns = listing_columns.restored(found)
        self._written = int(found["commit"])
        return State(self._written, columns, whole_since=tx.pruning.whole_since())

    def _keep(self, tx: Transaction, state: State) -> None:
        """Store the state for other processes, unless the stored one is nearly the same: they read the changes
        since.
        """
        whole, commit = state.whole or [], state.commit
        if (
            self._sidecar is not None
            and len(whole) >= groups.LASTING
            and not self._written <= commit < self._written + FEW
        ):
            self._written = commit
            self._sidecar.keep(tx, LISTING, lambda: listing_columns.columns(whole, commit), 100 * len(whole))

    def groups(self, tx: Transaction, state: State, projects: Projects | None) -> list[Group]:
        """The same, of some projects or all, in groups."""
        found = state.groups.get(projects)
        if found is None:
            whole = self.whole(tx, state)
            wanted = whole if projects is None else [listed for listed in whole if listed.project in projects]
            if len(state.groups) >= VIEWS:
                state.groups.clear()
            found = state.groups[projects] = self._groups.cut(wanted)
            if tx.at >= tx.newest_commit():
                self._groups.hold_view(projects, found)
        return found

    def cut(self, documents: list[Listed]) -> list[Group]:
        """Some documents in groups."""
        return [self._groups.hold_chosen(group) for group in self._groups.cut(documents)]

    def group(self, documents: list[Listed]) -> Group:
        """Some documents as one group."""
        return self._groups.hold_chosen(self._groups.group(documents))


def _changed(tx: Transaction, whole: list[Listed], commit: int) -> list[Listed]:
    """All documents, given those of an earlier commit: every change, a deletion too, is a revision."""
    changed = tx.columns.changed_since(commit)
    if not changed:
        return whole
    gone = set(changed)
    kept = [listed for listed in whole if listed.key not in gone]
    new = tx.columns.documents(changed)
    return sorted([*kept, *new], key=_in_order) if new else kept


def _in_order(listed: Listed) -> tuple[str, int]:
    return listed.name, listed.key


class Scope:
    """The documents of a query. keys: of the documents, None for all. projects: of these projects, None: of all."""

    def __init__(self, tx: Transaction, listing: Listing, documents: Sequence[str] = (), project: str | None = None):
        """documents: by their ids, or collections of them; all if none is given. Never others than the transaction's
        view has. NotFoundError for documents or projects that do not exist."""
        self._tx = tx
        self._listing = listing
        named = tx.saved.expand(documents)
        self.keys = [self._key(uuid) for uuid in dict.fromkeys(named)] if documents else None
        self.projects: Projects | None = frozenset({tx.projects.get(project)}) if project else None
        if self.keys is None and not tx.view.is_whole:
            self._see_less()

    def _see_less(self) -> None:
        """Leave out what is in projects that are not seen."""
        if self._tx.at >= self._tx.newest_commit():
            self.projects = self.projects or self._tx.view.readable
        else:
            # Where a document was then is not where it is now, which decides.
            self.keys = sorted(self._tx.documents.seen() or ())

    def narrow(self, documents: Sequence[Listed]) -> None:
        """Limit the scope to these documents."""
        self.keys = [listed.key for listed in documents]

    @cached_property
    def state(self) -> State:
        return self._listing.state(self._tx)

    def documents(self, keys: Sequence[int] | None = None) -> list[Listed]:
        """The documents by name, then key, the order of answers. keys: only these documents of the scope."""
        found = self._listed(self.keys if keys is None else keys)
        return found if self.projects is None else [listed for listed in found if listed.project in self.projects]

    def _listed(self, keys: Sequence[int] | None) -> list[Listed]:
        state = self.state
        if keys is None:
            return self._listing.whole(self._tx, state)
        missing = [key for key in keys if key not in state.documents]
        if missing and state.whole is None:
            state.documents.update({listed.key: listed for listed in self._tx.columns.documents(missing)})
        chosen = [state.documents[key] for key in dict.fromkeys(keys) if key in state.documents]
        return sorted(chosen, key=_in_order)

    def groups(self, documents: list[Listed] | None = None) -> list[Group]:
        """The documents in groups. documents: only these of them, in order; all, if none are given."""
        if self.keys is None and documents is None:
            return self._listing.groups(self._tx, self.state, self.projects)
        few = self.documents() if documents is None else documents
        return [self._listing.group(few[at : at + FEW_DOCUMENTS]) for at in range(0, len(few), FEW_DOCUMENTS)]

    def used_names(self, kind: Kind) -> list[str]:
        """The different names of bones, or the motion names, that occur."""
        return self._tx.columns.used_names(kind, self.narrowed())

    def used_counts(self, kind: Kind) -> dict[str, int]:
        """The same, by code point, with how many documents have each."""
        return self._tx.columns.used_counts(kind, self.narrowed())

    def unused_names(self, tree: Expression) -> list[str]:
        """For each text that names are compared with and that none here equals, the nearest one that occurs."""
        asked = None if self.keys is None else tuple(self.keys)
        found = []
        for kind, said in compared_names(tree):
            warnings = self.state.unused
            if len(warnings) > KNOWN_NAMES:
                warnings.clear()
            if (kind, said, asked, self.projects) not in warnings:
                used = self._tx.columns.is_used(kind, said, self.narrowed())
                warnings[kind, said, asked, self.projects] = (
                    None if used else not_found(kind, said, self.used_names(kind))
                )
            found.append(warnings[kind, said, asked, self.projects])
        return [warning for warning in found if warning is not None]

    def narrowed(self) -> list[int] | None:
        """Keys of the documents, None for all."""
        return self.keys if self.projects is None else [listed.key for listed in self.documents()]

    def _key(self, uuid: str) -> int:
        keys = self.state.keys
        if uuid not in keys or not self._tx.view.is_whole:
            keys[uuid] = self._tx.documents.get(uuid).key
        return keys[uuid]
