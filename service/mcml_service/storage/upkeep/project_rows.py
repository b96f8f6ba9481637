"""A project as self-contained rows: keys and commits are numbered from 1, so that equal projects in any stores have
equal rows. For moving a project, with every revision, from one store to another. Not included are derived data
(thumbnails, bodies, checksums), temporary data (jobs), and members. Uploaded files are identified by their SHA-256;
their bytes are stored beside the rows.
"""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from sqlalchemy import Column, ColumnElement, LargeBinary, Table, select

from mcml.errors import FormatError
from mcml_service.storage.core import tables
from mcml_service.storage.core.identifiers import new_uuid
from mcml_service.storage.core.schema import CHANNEL_ENDS, CURRENT
from mcml_service.storage.core.seals import SEALS, add_checksums
from mcml_service.storage.documents.damage import describe_damage, describe_track_damage
from mcml_service.storage.work import tables as work_tables

if TYPE_CHECKING:
    from mcml_service.storage.transaction import Transaction

Row: TypeAlias = dict[str, Any]
Kind: TypeAlias = str
"""Of a number: "commit", or the name of the table whose key it is."""

ROWS = 1000

_OF_DOCUMENTS = (
    *(tables.revision, tables.content, tables.header, tables.property_, tables.bone, tables.timeline, tables.frame_run),
    *(tables.shape, tables.shape_run, tables.span, tables.track, tables.document_upload, tables.document_media),
    *(work_tables.comment, work_tables.proposal),
)
_OF_PROJECTS = (work_tables.joint_mapping, work_tables.joint_alias, work_tables.saved)
_OF_RESULTS = (work_tables.result_part, work_tables.result_block)

MOVED: Final = {
    str(table.name): table
    for table in (
        *(tables.commit, tables.upload, tables.skeleton, tables.skeleton_element, tables.document),
        *(*_OF_DOCUMENTS, *_OF_PROJECTS, work_tables.result, *_OF_RESULTS),
    )
}
"""By their names, in an order in which what is referred to comes first."""

ADDED_TABLES: Final = frozenset({"proposal"})
"""Tables that files of older programs lack."""

_KINDS: Mapping[str, Kind] = {
    **{name: name for name in ("document", "skeleton", "upload", "result")},
    **dict.fromkeys(("commit", "from_commit", "to_commit", "created_commit", "deleted_commit"), "commit"),
}
_OWN_KEY = {"commit": "number", **dict.fromkeys(("document", "skeleton", "upload", "result"), "id")}
_FIXED = (0, CURRENT, None)
"""Values in commit columns that are not commits."""
_NO_ZONES: Row = dict.fromkeys(CHANNEL_ENDS)
"""Of channels that the program which wrote a track did not know; its checksum counts all others."""
_ADDED: Mapping[str, Row] = {tables.track.name: _NO_ZONES, work_tables.comment.name: {"proposal": None}}
"""Values of columns that rows of older programs lack."""
_REFERRING = {"result": ("inputs", "parameters"), "saved": ("content",), "proposal": ("content", "inputs")}
"""Columns whose texts name documents by their ids."""


def _kind(table: Table, column: str) -> Kind | None:
    """Return the kind of the keys in a column, None if its values are kept unchanged."""
    if _OWN_KEY.get(table.name) == column:
        return table.name
    if table is work_tables.result and column == "parent":
        return "result"
    return _KINDS.get(column)


def _columns(table: Table) -> list[str]:
    """Return the columns that are moved."""
    left = {"project", "checksum", "data_checksum", "lease"}
    if table.name not in _OWN_KEY:
        left.add("id")
    return [str(column.name) for column in table.columns if column.name not in left]


class ProjectRows:
    """The rows of a project of one store, or of one document alone. Raises DamageError for damaged rows."""

    def __init__(self, tx: Transaction, project_key: int | None, document_key: int | None = None) -> None:
        self._tx = tx
        self._project = project_key
        its_own = tables.document.c.project == project_key
        if document_key is not None:
            its_own = tables.document.c.id == document_key
        ready = its_own & (tables.document.c.state == "ready")
        self.documents = self._keys(select(tables.document.c.id).where(ready))
        self._results = self._keys(select(work_tables.result.c.id).where(work_tables.result.c.project == project_key))
        skeletons: set[int] = set()
        uploads: set[int] = set()
        commits: set[int] = set()
        for part in _parts(self.documents):
            skeletons |= set(self._keys(_of(tables.content.c.skeleton, tables.content, part)))
            for table in (tables.document_upload, tables.document_media):
                uploads |= set(self._keys(_of(table.c.upload, table, part)))
            commits |= set(self._keys(_of(tables.revision.c.commit, tables.revision, part)))
            known = tables.document.c.id.in_(part)
            for column in (tables.document.c.created_commit, tables.document.c.deleted_commit):
                commits |= set(self._keys(select(column).where(known).distinct()))
            for table in _OF_DOCUMENTS:
                if "from_commit" in table.c:
                    for column in (table.c.from_commit, table.c.to_commit):
                        commits |= set(self._keys(_of(column, table, part)))
        # The skeleton of a moved document stays in the old project; an equal one may exist here.
        same = self._equal(sorted(skeletons))
        alike = {hashed: min(keys) for hashed, keys in same.items()}
        self._among = {
            "document": self.documents,
            "skeleton": list(alike.values()),
            "upload": sorted(uploads),
            "result": self._results,
            "commit": sorted(commits - {0, CURRENT}),
        }
        self._numbers = {
            kind: {key: number for number, key in enumerate(keys, 1)} for kind, keys in self._among.items()
        }
        numbers = self._numbers["skeleton"]
        numbers.update({key: numbers[alike[hashed]] for hashed, keys in same.items() for key in keys})

    def _equal(self, skeletons: list[int]) -> dict[str, list[int]]:
        """Keys of skeletons by their hash, in the order of the first of each."""
        keys_by_hash: dict[str, list[int]] = {}
        for part in _parts(skeletons):
            query = select(tables.skeleton.c.hash, tables.skeleton.c.id).where(tables.skeleton.c.id.in_(part))
            for hashed, key in self._tx.fetch_all(query.order_by(tables.skeleton.c.id)):
                keys_by_hash.setdefault(hashed, []).append(key)
        return keys_by_hash

    @property
    def uploads(self) -> list[int]:
        """Keys of the kept files."""
        return self._among["upload"]

    def _keys(self, query: Any) -> list[int]:
        return sorted(key for key in self._tx.fetch_column(query) if key is not None)

    def of(self, table: Table) -> Iterator[Row]:
        """The rows of a table, in order."""
        for condition in self._conditions(table):
            names = [str(column.name) for column in table.columns]
            query = select(table).where(condition).order_by(*table.primary_key)
            for block in self._tx.stream(query, ROWS):
                self._require_sound(table, names, block)
                for row in block:
                    yield self._export_row(table, {str(name): value for name, value in row._mapping.items()})

    def files(self) -> Iterator[tuple[str, Callable[[], Iterator[bytes]]]]:
        """(SHA-256, content) of the kept files."""
        for key in self.uploads:
            query = select(tables.upload.c.sha256).where(tables.upload.c.id == key)
            (sha256,) = self._tx.fetch_column(query)
            yield str(sha256), lambda key=key: self._tx.uploads.blocks(key)  # type: ignore[misc]

    def _conditions(self, table: Table) -> Iterator[ColumnElement[bool]]:
        if "project" in table.c and table not in (tables.document, tables.skeleton, tables.revision):
            yield table.c.project == self._project
            return
        kind = next(kind for kind in _OWN_KEY if kind in table.c) if table.name not in _OWN_KEY else table.name
        column = table.c[_OWN_KEY[kind]] if table.name in _OWN_KEY else table.c[kind]
        if table in _OF_RESULTS:
            kind, column = "result", table.c.result
        elif table in _OF_DOCUMENTS:
            kind, column = "document", table.c.document
        for part in _parts(self._among[kind]):
            yield column.in_(part)

    def _export_row(self, table: Table, row: Mapping[str, Any]) -> Row:
        told: Row = {}
        for name in _columns(table):
            value, kind = row[name], _kind(table, name)
            if kind == "commit":
                value = value if value in _FIXED else self._numbers["commit"][value]
            elif kind is not None:
                # A result's clip in another project is not included.
                value = None if value is None else self._numbers[kind].get(value)
            elif isinstance(table.c[name].type, LargeBinary):
                value = b64encode(value).decode()
            elif isinstance(value, float):
                # SQLite has no negative zero.
                value += 0.0
            told[name] = value
        return told

    def _require_sound(self, table: Table, names: list[str], block: Iterable[Any]) -> None:
        """DamageError where a row has not the checksums that it would be given."""
        if table not in SEALS and table is not tables.track:
            return
        kept = tuple(name for name in names if name not in ("checksum", "data_checksum"))
        places = [names.index(name) for name in kept]
        rows = [tuple(row) for row in block]
        made, again = add_checksums(table, kept, [tuple(row[place] for place in places) for row in rows])
        sums = [names.index(name) for name in made[len(kept) :]]
        for row, other in zip(rows, again, strict=True):
            if tuple(row[place] for place in sums) != tuple(other[len(kept) :]):
                if table is tables.track:
                    raise describe_track_damage(
                        self._tx, *(row[names.index(name)] for name in ("document", "chunk", "bone"))
                    )
                raise describe_damage(
                    self._tx, table, tuple(row[names.index(column.name)] for column in SEALS[table].read)
                )


def _of(column: Any, table: Table, documents: list[int]) -> Any:
    return select(column).where(table.c.document.in_(documents)).distinct()


def _parts(keys: list[int]) -> Iterator[list[int]]:
    """Some at a time, as statements take them."""
    for start in range(0, len(keys), ROWS):
        yield keys[start : start + ROWS]


@dataclass
class ProjectWriter:
    """Writes rows of a project to another store, as a new project.

    keys: new keys of the numbers in the rows, by kind. uuids: ids already in use here, and their replacements.
    """

    tx: Transaction
    project_key: int
    keys: dict[Kind, dict[int, int]] = field(default_factory=dict)
    uuids: dict[str, str] = field(default_factory=dict)
    uploads: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        # No other transaction may take a commit until these are written.
        self._first = max(self.tx.commit, self.tx.newest_commit())
        self._there: set[int] = set()

    def write(self, table: Table, rows: Iterable[Row]) -> int:
        """Write the rows of a table; return their number. Raises FormatError for invalid rows."""
        count = 0
        block: list[Row] = []
        for row in rows:
            row = {**_ADDED.get(table.name, {}), **row}
            if set(row) != set(_columns(table)):
                raise FormatError(f"This is no row of {table.name}: {', '.join(sorted(row))[:200]}.")
            count += 1
            if table is tables.skeleton_element and row["skeleton"] in self._there:
                continue
            if table.name in _OWN_KEY:
                self._write_keyed(table, row)
                continue
            block.append(self._here(table, row))
            if len(block) == ROWS:
                self.tx.insert_rows(table, block)
                block = []
        self.tx.insert_rows(table, block)
        return count

    def _write_keyed(self, table: Table, row: Row) -> None:
        """Write a row to which others refer."""
        keys = self.keys.setdefault(table.name, {})
        number = row[_OWN_KEY[table.name]]
        if not isinstance(number, int) or number != len(keys) + 1:
            raise FormatError(f"Rows of {table.name} are numbered from 1.", remedy="Export the project again.")
        if table is tables.commit:
            # This transaction's own commit is the first of them, with the original data.
            keys[number] = self._first + number
            self.tx.insert_rows(table, [{**row, "number": keys[number]}])
            return
        if table is tables.upload:
            equal = self.uploads.get(str(row["sha256"]))
            if equal is None:
                raise FormatError(f"The file {row['sha256']} is missing.", remedy="Export the project again.")
            keys[number] = equal
            return
        own = {name: value for name, value in self._here(table, row).items() if name != "id"}
        if "uuid" in own:
            own["uuid"] = self._uuid(table, own["uuid"])
        equal = self._equal_skeleton(own) if table is tables.skeleton else None
        if equal is not None:
            self._there.add(number)
        keys[number] = self.tx.insert_row(table, **own) if equal is None else equal

    def _equal_skeleton(self, row: Row) -> int | None:
        """The key of a skeleton that the project has."""
        its_own = (tables.skeleton.c.project == self.project_key, tables.skeleton.c.hash == row["hash"])
        key: int | None = self.tx.fetch_value(select(tables.skeleton.c.id).where(*its_own))
        return key

    def _here(self, table: Table, row: Row) -> Row:
        """A row as this store has it."""
        here: Row = {"project": self.project_key} if "project" in table.c else {}
        for name, value in row.items():
            kind = _kind(table, name)
            if _OWN_KEY.get(table.name) == name:
                continue
            try:
                if kind == "commit":
                    value = value if value in _FIXED else self.keys["commit"][value]
                elif kind is not None:
                    value = None if value is None else self.keys[kind][value]
                elif isinstance(table.c[name].type, LargeBinary):
                    value = b64decode(value, validate=True)
                elif name in _REFERRING.get(table.name, ()):
                    for old, new in self.uuids.items():
                        value = value.replace(old, new)
            except (KeyError, ValueError, TypeError, AttributeError):
                raise FormatError(
                    f"A row of {table.name} makes no sense: its {name}.", remedy="Export the project again."
                ) from None
            if not _fits(table.c[name], value):
                raise FormatError(f"A row of {table.name} makes no sense: its {name} is {value!r:.60}.")
            here[name] = value
        return here

    def _uuid(self, table: Table, uuid: str) -> str:
        """The same, or a new one where it is taken here."""
        taken = self.tx.fetch_one(select(table.c.id).where(table.c.uuid == uuid))
        if taken is None:
            return uuid
        self.uuids[uuid] = new_uuid()
        return self.uuids[uuid]


def _fits(column: Column[Any], value: object) -> bool:
    """Whether a value is of the type of a column: SQLite would keep any."""
    if value is None:
        return bool(column.nullable)
    kind = column.type.python_type
    if kind is int:
        return type(value) is int and -(2**63) <= value < 2**63
    return isinstance(value, (int, float) if kind is float else kind) and (kind is bool or not isinstance(value, bool))


def copy_document(tx: Transaction, document_key: int, project_key: int) -> str:
    """The id of a copy of a document with its whole history, in a project."""
    rows = ProjectRows(tx, None, document_key)
    writer = ProjectWriter(tx, project_key)
    for sha256, size in tx.fetch_all(
        select(tables.upload.c.sha256, tables.upload.c.size).where(tables.upload.c.id.in_(rows.uploads))
    ):
        writer.uploads[sha256] = tx.uploads.find(sha256, size) or 0
    for table in MOVED.values():
        # All rows must have been read before the same connection writes.
        writer.write(table, list(rows.of(table)))
    return next(iter(writer.uuids.values()))
