"""Execute SQL statements on a connection: the one module that does (`tests/architecture`).

A statement is one of four things: a text in SQL; a statement of SQLAlchemy that is built where it is used; one of
these whose rows are compared with their checksums (`seals.verify`); or one that the program makes once (`Prepared`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias, cast, overload

from sqlalchemy import ClauseElement, ColumnElement, Connection, CursorResult, Dialect, Executable, Select, Table
from sqlalchemy import Row as NamedRow
from sqlalchemy.sql.compiler import SQLCompiler

from mcml.errors import DamageError
from mcml_service.storage.core.seals import REMEDY, Checked, Row
from mcml_service.storage.core.sql_expressions import IntegerList

Values: TypeAlias = Mapping[str, Any]
"""Values of the parameters of a statement, by name. Lists of integers are for `OneOf`."""

Record: TypeAlias = NamedRow[*tuple[Any, ...]]
"""A row of a statement of SQLAlchemy: its values in order, and by name."""

MOST_REMEMBERED: Final = 10_000
"""Results of which a statement remembers that their checksums were compared."""


@dataclass(frozen=True, slots=True)
class _Text:
    """A statement in SQL.

    values: of its own parameters. places: the names of all parameters in order, if the driver uses positions. lists:
    parameters that take a list of integers.
    """

    text: str
    values: dict[str, Any]
    places: Sequence[str] | None
    lists: Mapping[str, IntegerList]


class Prepared:
    """A statement that the program makes once, and reads or writes often: its text is made once too.

    SQLAlchemy takes several times as long to look for that text as SQLite takes to answer it, and its own rows take
    longer than short reads: the text goes to the driver, and rows are plain tuples.
    """

    def __init__(self, statement: ClauseElement, *sealed: Table, remember: bool = False) -> None:
        """sealed: the tables of which rows are compared with their checksums. remember: do not compare a result again
        that this process has compared before, for statements that often read the same many rows."""
        self.statement = statement
        self._sealed = sealed
        self.checks = Checked(cast(Select[Any], statement), sealed) if sealed else None
        self.remembered: set[int] | None = set() if remember else None
        self._texts: dict[tuple[str, bool], _Text] = {}

    def where(self, *conditions: ColumnElement[bool]) -> Prepared:
        """Return the same with more conditions."""
        narrowed = cast(Select[Any], self.statement).where(*conditions)
        return Prepared(narrowed, *self._sealed, remember=self.remembered is not None)

    def write(self, dialect: Dialect, values: Values, *, with_checksums: bool) -> tuple[str, Any]:
        """Return the text of the statement and the values as the driver takes them."""
        known = (dialect.name, with_checksums)
        text = self._texts.get(known)
        if text is None:
            text = self._texts[known] = self._compile(dialect, with_checksums=with_checksums)
        arguments = {**text.values, **values}
        for name, kind in text.lists.items():
            arguments[name] = kind.process_bind_param(arguments[name], dialect)
        return text.text, arguments if text.places is None else tuple([arguments[name] for name in text.places])

    def _compile(self, dialect: Dialect, *, with_checksums: bool) -> _Text:
        statement = self.checks.statement if self.checks is not None and with_checksums else self.statement
        compiled = cast(SQLCompiler, statement.compile(dialect=dialect))
        lists = {name: bind.type for name, bind in compiled.binds.items() if isinstance(bind.type, IntegerList)}
        return _Text(compiled.string, compiled.params, compiled.positiontup, lists)


class Statements:
    """Statements on one connection. Parameters are passed by name."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection

    @overload
    def fetch_all(self, statement: Prepared | Checked, values: Values | None = None) -> list[Row]: ...

    @overload
    def fetch_all(self, statement: Executable | str, values: Values | None = None) -> list[Record]: ...

    def fetch_all(self, statement: Prepared | Checked | Executable | str, values: Values | None = None) -> list[Any]:
        """Return all rows. DamageError for the first that has not its checksum, where the statement compares them."""
        if isinstance(statement, Prepared):
            if statement.remembered is not None:
                return self._fetch_remembered(statement, statement.remembered, values or {})
            rows = self._on_driver(statement, values, with_checksums=True).fetchall()
            return rows if statement.checks is None else self._compare(statement.checks, rows)
        if isinstance(statement, Checked):
            return self._compare(statement, [tuple(row) for row in self._execute(statement.statement, values)])
        return list(self._execute(statement, values).all())

    @overload
    def fetch_one(self, statement: Prepared | Checked, values: Values | None = None) -> Row | None: ...

    @overload
    def fetch_one(self, statement: Executable | str, values: Values | None = None) -> Record | None: ...

    def fetch_one(self, statement: Prepared | Checked | Executable | str, values: Values | None = None) -> Any:
        """Return the first row, None if there is none."""
        if isinstance(statement, Prepared | Checked):
            return next(iter(self.fetch_all(statement, values)), None)
        return self._execute(statement, values).first()

    def fetch_value(self, statement: Prepared | Checked | Executable | str, values: Values | None = None) -> Any:
        """Return the first value of the first row, None if there is no row."""
        row = self.fetch_one(statement, values)
        return None if row is None else row[0]

    def fetch_column(self, statement: Prepared | Checked | Executable | str, values: Values | None = None) -> list[Any]:
        """Return the first value of each row."""
        return [row[0] for row in self.fetch_all(statement, values)]

    @overload
    def stream(self, statement: Checked, size: int) -> Iterator[Sequence[Row]]: ...

    @overload
    def stream(self, statement: Select[Any], size: int) -> Iterator[Sequence[Record]]: ...

    def stream(self, statement: Checked | Select[Any], size: int) -> Iterator[Sequence[Any]]:
        """Yield blocks of a limited number of rows, which are never all in memory at once."""
        read = statement.statement if isinstance(statement, Checked) else statement
        for block in self.connection.execute(read, execution_options={"yield_per": size}).partitions(size):
            yield self._compare(statement, list(map(tuple, block))) if isinstance(statement, Checked) else block

    def run(
        self,
        statement: Prepared | Executable | str,
        values: Values | Sequence[Values] | Sequence[Row] | Row | None = None,
    ) -> int:
        """Run a statement that changes something, now; return the number of rows that it changed.

        values: a sequence runs it once for each. Values of a text in SQL are in the order of their places.
        """
        if isinstance(statement, Prepared):
            return int(self._on_driver(statement, cast(Values, values), with_checksums=False).rowcount)
        return int(self._execute(statement, values).rowcount)

    def damage(self, table: Table, row: Row) -> DamageError:
        """Return the error for a row with a wrong checksum. row: the columns that its seal reads."""
        return DamageError(f"The store is damaged: a row of {table.name!r}.", remedy=REMEDY)

    def _execute(self, statement: Executable | str, values: Any) -> CursorResult[Any]:
        if isinstance(statement, str):
            return self.connection.exec_driver_sql(statement, values)
        return cast(CursorResult[Any], self.connection.execute(statement, values))

    def _on_driver(self, statement: Prepared, values: Values | None, *, with_checksums: bool) -> Any:
        """Return the cursor of the driver itself."""
        text, arguments = statement.write(self.connection.dialect, values or {}, with_checksums=with_checksums)
        return execute_on_driver(self.connection.connection.driver_connection, text, arguments)

    def _compare(self, statement: Checked, rows: Sequence[Row]) -> list[Row]:
        wanted, damaged = statement.check(rows)
        if damaged is not None:
            raise self.damage(*damaged)
        return wanted

    def _fetch_remembered(self, statement: Prepared, remembered: set[int], values: Values) -> list[Row]:
        rows: list[Row] = self._on_driver(statement, values, with_checksums=False).fetchall()
        mark = hash(tuple(rows))
        if mark not in remembered and statement.checks is not None:
            checked = self._on_driver(statement, values, with_checksums=True).fetchall()
            rows = self._compare(statement.checks, checked)
            if len(remembered) >= MOST_REMEMBERED:
                remembered.clear()
            remembered.add(mark)
        return rows


def execute_on_driver(driver: Any, text: str, values: Any = ()) -> Any:
    """Execute SQL on a connection of the driver itself, and return the driver's cursor.

    It is for hooks of connection pools, and where SQLAlchemy's part takes longer than the database's.
    """
    return driver.execute(text, values)
