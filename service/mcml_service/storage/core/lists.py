"""Parts of statements that each kind of database writes in a way of its own."""

from __future__ import annotations

from typing import Any

from sqlalchemy import BindParameter, Column, ColumnElement, String, bindparam
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.compiler import SQLCompiler
from sqlalchemy.sql.functions import FunctionElement


class OneOf(ColumnElement[bool]):
    """Whether a column is one of the integers in a list, which is given by a name to `Transaction.run`."""

    inherit_cache = False

    def __init__(self, column: Column[Any], name: str, values: Any = None) -> None:
        """values: the list itself, as the dialect takes it, for a statement that is made for it."""
        self.column = column
        self.values: BindParameter[Any] = bindparam(name, values)


@compiles(OneOf, "sqlite")
def _in_json(element: OneOf, compiler: SQLCompiler, **how: Any) -> str:
    column, values = compiler.process(element.column, **how), compiler.process(element.values, **how)
    return f"{column} IN (SELECT value FROM json_each({values}))"


@compiles(OneOf, "postgresql")
def _in_array(element: OneOf, compiler: SQLCompiler, **how: Any) -> str:
    column, values = compiler.process(element.column, **how), compiler.process(element.values, **how)
    return f"{column} = ANY(CAST({values} AS bigint[]))"


class AsWritten(FunctionElement[str]):
    """A text that is compared code point by code point, whatever language the database is set to."""

    type = String()
    inherit_cache = True


@compiles(AsWritten, "sqlite")
def _plain(element: AsWritten, compiler: SQLCompiler, **how: Any) -> str:
    return compiler.process(element.clauses, **how)


@compiles(AsWritten, "postgresql")
def _in_collation_c(element: AsWritten, compiler: SQLCompiler, **how: Any) -> str:
    return f'({compiler.process(element.clauses, **how)} COLLATE "C")'
