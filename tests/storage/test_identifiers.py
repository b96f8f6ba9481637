"""Identifiers sort by creation, also those of one millisecond, and are never twice the same."""

from __future__ import annotations

import time
import uuid
from concurrent.futures import ThreadPoolExecutor
from itertools import chain

from mcml_service.storage.core.identifiers import new_uuid


def test_identifiers_sort_by_creation() -> None:
    before = time.time_ns() // 1_000_000
    made = [new_uuid() for _ in range(5000)]
    assert made == sorted(made)
    for text in made[::500]:
        one = uuid.UUID(text)
        assert (one.version, one.variant) == (7, uuid.RFC_4122)
        assert before <= one.int >> 80 <= time.time_ns() // 1_000_000 + 5


def test_threads_make_different_identifiers_in_order() -> None:
    with ThreadPoolExecutor(4) as pool:
        parts = list(pool.map(lambda _: [new_uuid() for _ in range(2000)], range(4)))
    assert all(part == sorted(part) for part in parts)
    # The time alone, without the random bits behind it, tells them apart.
    assert len({text[:18] for text in chain.from_iterable(parts)}) == 8000
