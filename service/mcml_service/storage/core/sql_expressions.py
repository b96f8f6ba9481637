"""Parts of statements that each kind of database writes differently."""

from __future__ import annotations

from typing import Any

import orjson
from sqlalchemy import BindParameter, Column, ColumnElement, Dialect, String, TypeDecorator, bindparam
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.compiler import SQLCompiler
from sqlalchemy.sql.functions import FunctionElement
from sqlalchemy.types import NullType


class IntegerList(TypeDecorator[list[int]]):
    """A list of integers as `OneOf` takes it: JSON in SQLite, an array in PostgreSQL."""

    impl = NullType
    cache_ok = True

    def process_bind_param(self, value: list[int] | None, dialect: Dialect) -> Any:
        return orjson.dumps(value).decode() if dialect.name == "sqlite" else value


class OneOf(ColumnElement[bool]):
    """Whether a column is one of the integers in a list, which a parameter of that name is given."""

    inherit_cache = False

    def __init__(self, column: Column[Any], name: str, values: list[int] | None = None) -> None:
        """values: the list itself, for a statement that is made for it."""
        self.column = column
        self.values: BindParameter[Any] = bindparam(name, values, IntegerList())


@compiles(OneOf, "sqlite")
def _in_json(element: OneOf, compiler: SQLCompiler, **how: Any) -> str:
    column, values = compiler.process(element.column, **how), compiler.process(element.values, **how)
    return f"{column} IN (SELECT value FROM json_each({values}))"


@compiles(OneOf, "postgresql")
def _in_array(element: OneOf, compiler: SQLCompiler, **how: Any) -> str:
    column, values = compiler.process(element.column, **how), compiler.process(element.values, **how)
    return f"{column} = ANY(CAST({values} AS bigint[]))"


class AsWritten(FunctionElement[str]):
    """A text that is compared code point by code point, with any locale of the database."""

    type = String()
    inherit_cache = True


@compiles(AsWritten, "sqlite")
def _plain(element: AsWritten, compiler: SQLCompiler, **how: Any) -> str:
    return compiler.process(element.clauses, **how)


@compiles(AsWritten, "postgresql")
def _in_collation_c(element: AsWritten, compiler: SQLCompiler, **how: Any) -> str:
    return f'({compiler.process(element.clauses, **how)} COLLATE "C")'
