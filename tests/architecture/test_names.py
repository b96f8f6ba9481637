"""Functions are verbs in the imperative: a participle says neither what a function does nor what it returns."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("service/mcml_service", "mcml/client")
ENGINE = ROOT / "service/mcml_service/xpath"

PARTICIPLES = frozenset(
    [
        "asked",
        "begun",
        "bound",
        "brought",
        "built",
        "caught",
        "chosen",
        "done",
        "drawn",
        "driven",
        "fallen",
        "found",
        "given",
        "gone",
        "held",
        "kept",
        "known",
        "left",
        "made",
        "met",
        "paid",
        "said",
        "seen",
        "sent",
        "shown",
        "sold",
        "spent",
        "spoken",
        "stood",
        "taken",
        "taught",
        "thought",
        "told",
        "understood",
        "won",
        "written",
    ]
)
"""Those that do not end with -ed."""
VERBS = frozenset({"need", "feed", "seed", "speed", "embed", "exceed", "proceed", "succeed"})
CALLED_BY_THE_ENGINE = frozenset({"bounded", "changed_since", "gathered", "named", "seen", "used_counts", "used_names"})
"""The query engine calls these, whose own names are still to come."""
LIMITS = frozenset({"_bound", "bound_growth"})
"""Here the verb is to bound."""


def is_participle(name: str) -> bool:
    """Whether a name begins with a participle; `find_chosen` and `is_kept` do not."""
    first = name.strip("_").split("_")[0]
    return first in PARTICIPLES or (first.endswith("ed") and len(first) > 3 and first not in VERBS)


def functions_of(module: ast.Module) -> Iterator[str]:
    """Names of all functions and methods but properties, which are nouns and adjectives."""
    for node in ast.walk(module):
        is_function = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        if is_function and not any("property" in ast.unparse(decorator) for decorator in node.decorator_list):
            yield node.name


def test_functions_are_no_participles() -> None:
    paths = (path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py") if ENGINE not in path.parents)
    names = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in paths
        for name in functions_of(ast.parse(path.read_text(encoding="utf-8")))
        if is_participle(name) and name not in CALLED_BY_THE_ENGINE | LIMITS
    }
    assert not names, "name these by a verb in the imperative"
    planted = ast.parse(
        "class Store:\n    def _kept(self): ...\n    @property\n    def held(self): ...\ndef joined(): ..."
    )
    assert sorted(filter(is_participle, functions_of(planted))) == ["_kept", "joined"]
