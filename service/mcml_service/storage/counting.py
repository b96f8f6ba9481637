"""Count sign-in attempts, each in its own transaction, so that refused attempts count too."""

from __future__ import annotations

from mcml.errors import AttemptsError
from mcml_service.storage.database import Database


def count_attempt(database: Database, of: dict[str, str]) -> None:
    """Count an attempt before it is made. AttemptsError where there were too many."""
    with database.read() as tx:
        # Refused attempts write nothing, so that a flood of them does not block writers.
        tx.attempts.require(of)
    with database.write("session") as tx:
        keys = tx.attempts.add(of)
    try:
        # Of many that come at once no more than the bound pass, without a lock: each counts after it was counted.
        with database.read() as tx:
            tx.attempts.require(of, counted=1)
    except AttemptsError:
        with database.write("session") as tx:
            tx.attempts.take_back(keys)
        raise


def forget_attempts(database: Database, of: dict[str, str]) -> None:
    """Reset the count after a successful attempt."""
    with database.write("session") as tx:
        tx.attempts.forget(of)
