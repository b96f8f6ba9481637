"""Shared parts of all tables: names of constraints, types of columns, and two numbers used in rows."""

from __future__ import annotations

from typing import Any

from sqlalchemy import BigInteger, Column, Integer, MetaData, String

from mcml.motion.skeleton import CHANNELS

CHUNK = 256
"""Frames in one track row."""

CURRENT = 2**63 - 1
"""`to_commit` of rows that no later commit has closed."""

NAME = String(1024).with_variant(String(1024, collation="C"), "postgresql")
"""Names compare by code point in every database, as XPath's string comparison does."""

KEY = BigInteger().with_variant(Integer, "sqlite")
"""SQLite numbers rows automatically only in a column of type INTEGER."""

CHANNEL_ENDS = tuple(f"{end}_{channel}" for channel in CHANNELS for end in ("min", "max"))
"""Columns of a zone map, in order."""


def checksum(name: str = "checksum") -> Column[int]:
    """Return the column of a row's checksum (`mcml_service.storage.core.seals`)."""
    return Column(name, BigInteger)


COVERED = "covered"


def cover(*columns: str, last: type[bytes | bool | int] | None = None) -> dict[str, Any]:
    """Return the metadata of a table: the columns that the checksum of a row covers, in order.

    last: the type of the last column's values, if JSON has none for them, or databases have several; int for a column
    that rows of older stores lack.
    """
    return {COVERED: (columns, last)}


metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "fk": "fk_%(table_name)s_%(column_0_N_name)s",
        "pk": "pk_%(table_name)s",
    }
)
