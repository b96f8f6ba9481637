"""The interface of a database dialect."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from sqlalchemy import Connection, Engine, Table

from mcml_service.storage.core.statements import Prepared


@dataclass(frozen=True, slots=True)
class Compaction:
    """The effect of compacting a store.

    bytes: bytes returned to the disk. room: disk space needed meanwhile. stops_writers: whether writers must wait until
    it is done.
    """

    bytes: int
    room: int = 0
    stops_writers: bool = False


class Dialect(ABC):
    """Connection settings and locks of one kind of database."""

    @classmethod
    @abstractmethod
    def create_engine(cls, url: str) -> Engine:
        """An engine whose read transactions see one snapshot and whose commits survive a power cut."""

    personal: ClassVar[bool]
    """Whether a store is a file of one person, as opposed to a server's for several."""

    tracks_by_key: ClassVar[Prepared]
    """Reads the tracks whose keys are in a JSON array `keys` of [document, chunk, bone, from_commit]: one by one
    from the index, for any number of documents.
    """

    tracks_over_chunks: ClassVar[Prepared]
    """Reads all tracks valid `at` a commit over the chunks that are in a JSON array `keys` of [document, chunk]."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    @abstractmethod
    def writing(self) -> AbstractContextManager[Connection]:
        """A connection in a write transaction, committed at the end or rolled back on any exception."""

    @abstractmethod
    def reading(self) -> AbstractContextManager[Connection]:
        """A connection in a read transaction: every statement sees the same snapshot."""

    def looking(self) -> AbstractContextManager[Connection]:
        """As `reading`, but each statement sees the current state: for callers that often run a single statement."""
        return self.reading()

    @abstractmethod
    def order_commits(self, connection: Connection) -> None:
        """Let no other writer number a commit until this transaction has ended: numbers follow visibility."""

    @abstractmethod
    def insert(
        self, connection: Connection, table: Table, names: tuple[str, ...], rows: Sequence[tuple[Any, ...]]
    ) -> None:
        """Insert many rows, each with the values of these columns, the fastest way the database has."""

    @abstractmethod
    def insert_one(self, connection: Connection, table: Table, row: dict[str, Any]) -> int:
        """Insert one row into a table that numbers its rows, and answer the number."""

    @abstractmethod
    def size(self, connection: Connection) -> dict[str, int]:
        """Bytes of the whole store ("total") and of the kept uploads ("uploads")."""

    @abstractmethod
    def retire_keys(self, connection: Connection) -> None:
        """Keep keys of documents and skeletons that this transaction deletes from being used again: data that
        processes cache under a key never changes.
        """

    @abstractmethod
    def erase_what_goes(self, connection: Connection) -> None:
        """Let rows that this transaction deletes leave nothing behind in the pages that they lay in."""

    @abstractmethod
    def settle(self) -> None:
        """Remove deleted data from the database's files, as far as possible while others work."""

    @property
    def file(self) -> Path | None:
        """The file of the store, None if it is not a file."""
        return None

    @abstractmethod
    def compaction(self) -> Compaction:
        """Return the effect that `compact` would have now."""

    @abstractmethod
    def compact(self, progress: Callable[[int], None]) -> None:
        """Return unused space to the disk, if possible in steps between which others can write.

        progress: called with the remaining bytes.
        """

    @abstractmethod
    def is_full(self, error: BaseException | None) -> bool:
        """Tell whether the driver's error means that the disk is full."""

    @abstractmethod
    def is_clash(self, error: BaseException | None) -> bool:
        """Tell whether the driver's error means that this transaction was aborted because it blocked another one."""

    @abstractmethod
    def is_away(self, error: BaseException | None) -> bool:
        """Tell whether the driver's error means that the database is temporarily unreachable."""

    @abstractmethod
    def is_damaged(self, error: BaseException | None) -> bool:
        """Tell whether the driver's error means that the database's own structures are damaged."""

    @abstractmethod
    def faults(self, connection: Connection) -> Iterator[str]:
        """Yield faults that the database itself finds in its pages and indexes, as text."""

    @abstractmethod
    def last_keys(self, connection: Connection) -> dict[str, int]:
        """The last key that each table gave, by its name, where rows of the table may be gone that had later ones."""

    @abstractmethod
    def after_copy(self, connection: Connection, last: dict[str, int]) -> None:
        """Number on from the keys of rows that were copied with theirs. last: `last_keys` of the source."""
