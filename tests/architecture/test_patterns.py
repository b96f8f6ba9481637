"""Regular expressions mean the same on every version of Python that is supported."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULES = [path for folder in ("mcml", "service", "schemas") for path in sorted((ROOT / folder).rglob("*.py"))]
# Python 3.11.0 to 3.11.4 match these wrongly within groups: https://github.com/python/cpython/issues/106052
SINCE_3_11 = re.compile(r"\(\?>|(?<!\\)[*?+}]\+")


def patterns(source: str) -> list[str]:
    """The texts that are given to functions of `re`."""
    return [
        part.value if isinstance(part.value, str) else part.value.decode("latin-1")
        for call in ast.walk(ast.parse(source))
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute)
        if isinstance(call.func.value, ast.Name) and call.func.value.id == "re" and call.args
        for part in ast.walk(call.args[0])
        if isinstance(part, ast.Constant) and isinstance(part.value, str | bytes)
    ]


@pytest.mark.parametrize(
    ("pattern", "is_new"), [("a*+b", True), ("(?>a)", True), (r"a\++", False), ("a+", False), ("[+]+", False)]
)
def test_possessive_patterns_are_found(pattern: str, is_new: bool) -> None:
    (found,) = patterns(f"re.compile({pattern!r})")
    assert bool(SINCE_3_11.search(found)) == is_new


def test_no_pattern_is_possessive() -> None:
    texts = {path: patterns(path.read_text(encoding="utf-8")) for path in MODULES if "node_modules" not in path.parts}
    assert sum(map(len, texts.values())) > 100
    wrong = [(str(path), text) for path, each in texts.items() for text in each if SINCE_3_11.search(text)]
    assert wrong == []
