"""Campaigns of `make fuzz`: new seeds, the same ones again where that is asked, and first those that failed."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests import conftest, fuzz


@pytest.fixture(autouse=True)
def failed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(fuzz, "FAILED", tmp_path / "made" / "failed_seeds")
    monkeypatch.setattr(fuzz, "SEED", 1)


def test_seeds_are_those_of_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    first = fuzz.seeds("tests/a.py::test_a", 50)
    assert len(set(first)) == 50
    assert fuzz.seeds("tests/a.py::test_a", 50) == first
    assert set(first).isdisjoint(fuzz.seeds("tests/a.py::test_b", 50))
    monkeypatch.setattr(fuzz, "SEED", 2)
    assert set(first).isdisjoint(fuzz.seeds("tests/a.py::test_a", 50))


def test_what_failed_comes_first() -> None:
    """Of a failed campaign the seed is kept; what passes, fails in its setup or has no seeds of ours is not."""

    def reported(name: str, mark: Any, when: str, failed: bool) -> None:
        item: Any = SimpleNamespace(
            nodeid=f"{name}[7-sqlite]",
            get_closest_marker=lambda _: mark,
            callspec=SimpleNamespace(params={"seed": 7}),
        )
        hook = conftest.pytest_runtest_makereport(item)
        next(hook)
        with pytest.raises(StopIteration):
            hook.send(SimpleNamespace(when=when, failed=failed))  # type: ignore[arg-type]

    campaign = pytest.mark.fuzz(seeds=3)
    reported("a", campaign, "call", True)
    reported("b", campaign, "call", False)
    reported("c", campaign, "setup", True)
    reported("d", pytest.mark.fuzz, "call", True)
    reported("e", None, "call", True)
    assert fuzz.seeds("a", 3)[0] == 7
    assert len(fuzz.seeds("a", 3)) == 4
    assert [len(fuzz.seeds(name, 3)) for name in "bcde"] == [3, 3, 3, 3]
