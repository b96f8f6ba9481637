"""Translate errors of databases, without SQL statements, which mean nothing to users."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from mcml.errors import (
    ClashError,
    ConflictError,
    DamageError,
    DocumentError,
    SpaceError,
    StoreError,
    UnavailableError,
)
from mcml_service.storage.core.dialects import Dialect
from mcml_service.storage.core.seals import REMEDY


@contextmanager
def translate(dialect: Dialect) -> Iterator[None]:
    """Translate errors of the database to errors of this program, without SQL statements."""
    # Bulk inserts use the driver directly, so its errors are not wrapped.
    driver = dialect.engine.dialect.loaded_dbapi
    try:
        yield
    except PoolTimeout as error:
        raise UnavailableError("All connections to the store are in use.", remedy="Try again soon.") from error
    except UnicodeDecodeError as error:
        # Even messages of the driver may be invalid text.
        raise DamageError("The store is damaged: a text cannot be read.", remedy=REMEDY) from error
    except (DBAPIError, driver.Error) as error:
        cause = error.orig if isinstance(error, DBAPIError) else error
        if isinstance(cause, driver.DataError):
            raise DocumentError(
                "The database cannot hold or compare a value of this request.",
                remedy="Look for NUL and for long names.",
            ) from error
        if isinstance(cause, driver.IntegrityError):
            raise ConflictError("Another write came in between.", remedy="Repeat the request.") from error
        if dialect.is_full(cause):
            raise SpaceError from error
        if dialect.is_clash(cause):
            raise ClashError from error
        if dialect.is_away(cause):
            raise UnavailableError("The store cannot be reached now.", remedy="Try again soon.") from error
        message = str(cause).strip().split("\n")[0]
        if dialect.is_damaged(cause):
            raise DamageError(f"The store is damaged: {message}.", remedy=REMEDY) from error
        raise StoreError(
            f"The store is unreachable: {message}", remedy="Check its address, the disk and your rights."
        ) from error
