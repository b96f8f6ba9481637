"""Sign-in attempts, counted for all servers of a store, with limits for each address and each name.

Rows are temporary, so they have no checksum.
"""

from __future__ import annotations

import math
import time
from collections.abc import Collection
from typing import TYPE_CHECKING, Final

from sqlalchemy import delete, func, select

from mcml.errors import AttemptsError
from mcml_service.storage.core.identifiers import digest_of, normalise_name
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.team.tables import attempt

if TYPE_CHECKING:
    pass

LIMITS: Final = {"address": (10, 60.0), "name": (30, 3600.0), "password": (30, 3600.0)}
"""Limits of attempts, each with its period in seconds.

name: of the account in a sign-in. password: name of the account whose current password is checked in a session; counted
separately, so that attackers cannot keep people from changing their password.
"""


class Attempts:
    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def require(self, of: dict[str, str], counted: int = 0) -> None:
        """Check the limits of attempts, `counted` of which are this one's own.

        Raises AttemptsError if there are too many. of: counted keys, by the names of LIMITS.
        """
        at = time.time()
        for kind, what in of.items():
            its = (attempt.c.sha256 == _digest(kind, what), attempt.c.expires > at)
            kept = select(func.count(), func.min(attempt.c.expires)).where(*its)
            ((number, first),) = self._tx.fetch_all(kept)
            if number - counted >= LIMITS[kind][0]:
                raise AttemptsError(max(1, math.ceil(first - at)))

    def add(self, of: dict[str, str]) -> list[int]:
        """Count one more; the keys of its rows."""
        at = time.time()
        self._tx.run(delete(attempt).where(attempt.c.expires <= at))
        return [
            self._tx.insert_row(attempt, sha256=_digest(kind, what), expires=at + LIMITS[kind][1])
            for kind, what in of.items()
        ]

    def take_back(self, keys: Collection[int]) -> None:
        """Remove refused attempts from the count."""
        self._tx.run(delete(attempt).where(attempt.c.id.in_(keys)))

    def forget(self, of: dict[str, str]) -> None:
        """Reset the count after a successful attempt."""
        its = attempt.c.sha256.in_([_digest(kind, what) for kind, what in of.items()])
        self._tx.run(delete(attempt).where(its))


def _digest(kind: str, what: str) -> str:
    return digest_of(f"{kind} {normalise_name(what)}")
