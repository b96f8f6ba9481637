"""Long campaigns: new seeds in each run of `make fuzz`, and those that failed before come first.

A campaign is marked `@pytest.mark.fuzz(seeds=50)` and has an argument `seed`. Property tests (`@given`) run in `make
fuzz` as well, with many examples; Hypothesis keeps in `.hypothesis/` the examples that fail.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterable
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import settings

SEED = int(os.environ.setdefault("MCML_FUZZ_SEED", "") or secrets.randbelow(10**9))
"""What all seeds of a run come from."""
# Workers of the tests, which this process starts, have the same.
os.environ["MCML_FUZZ_SEED"] = str(SEED)

FAILED = Path(__file__).parents[1] / ".hypothesis" / "failed_seeds"
"""A line for each campaign and seed that failed. Whoever has mended the fault takes its line away."""

MORE = 25
"""Times as many examples in `make fuzz`, where a property test says how few `make test` can do with."""


def asked_for(config: pytest.Config) -> bool:
    """Whether this is a run of `make fuzz`."""
    return "fuzz" in config.getoption("-m")


def examples(few: int, many: int | None = None) -> settings:
    """For property tests that take long: so few in `make test`. many: in `make fuzz`, if not `MORE` times."""
    is_long = settings.get_current_profile_name() == "fuzz"
    return settings(max_examples=few if not is_long else few * MORE if many is None else many)


def share(values: Iterable[Any], every: int, first: int = 0) -> list[Any]:
    """Parameters of a test, of which `make test` has one in so many from the first on, and `make fuzz` the others."""
    return [
        value if place % every == first else pytest.param(value, marks=pytest.mark.fuzz)
        for place, value in enumerate(values)
    ]


def lengths(short: int, long: int) -> list[Any]:
    """How many times a test asks by chance: so few in `make test`, and in `make fuzz` so many."""
    return [short, pytest.param(long, marks=pytest.mark.fuzz)]


def seeds(test: str, count: int) -> list[int]:
    """Those of a campaign; test: its id without parameters."""
    kept = FAILED.read_text().splitlines() if FAILED.exists() else []
    before = [int(line.split()[1]) for line in kept if line.split()[:1] == [test]]
    # Neighbours of a seed are a campaign's own.
    return [*dict.fromkeys(before), *Random(f"{SEED} {test}").sample(range(10**4, 10**9, 10**4), count)]


def keep(test: str, seed: int) -> None:
    """To be tried first from now on."""
    FAILED.parent.mkdir(exist_ok=True)
    with FAILED.open("a") as file:
        file.write(f"{test} {seed}\n")
