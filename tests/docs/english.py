"""Check that texts are plain English: `python -m tests.docs.english`, a part of `make check`.

A text breaks a rule where a clause takes the place of a noun ("what is stored already" for "existing clips"), or where
it has a word of no manual ("thereof", "whoever"). Areas that are not mended yet have a budget, which may only fall.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BEFORE = (
    "of to by for with from than as and or in on but not at into about is are says? tells? shows? knows? sees? reads? "
    "lets? makes? gives? only all after before where that then"
).replace(" ", "|")
RULES = {
    "a clause in the place of a noun: name the thing": re.compile(
        rf"(?:^|[.:;,(] |\b(?:{BEFORE})\s)(?:who|what)\s+(?!is this\b|to do\b)\w+"
        r"|\b(?:that which|those of which|such as (?:is|are))\b",
        re.IGNORECASE | re.MULTILINE,
    ),
    "a word that manuals do not use": re.compile(
        r"\b(?:whoever|whatever|whichever|thereof|thereby|whereby|hence|shall|so-called|as it were|anew|called so|"
        r"(?:is|are) none of|tak(?:e|es|en|ing) away|told of|comes? along)\b",
        re.IGNORECASE,
    ),
}
CODE = re.compile(r"```.*?```|`[^`]*`", re.DOTALL)
SENTENCE = re.compile(r"[a-z]{2,} [a-z]{2,}")

BUDGETS = {"studio": 0, "operations and commands": 0, "errors": 0, "guides": 0, "pages": 3, "docstrings": 0}
"""How many places of each area may break a rule."""


@dataclass(frozen=True)
class Fault:
    """A place that breaks a rule."""

    place: str
    words: str
    rule: str


def check_text(place: str, text: str) -> Iterator[Fault]:
    """Yield the places of a text that break a rule. Code in backticks counts as a noun."""
    plain = CODE.sub("X", text)
    for rule, pattern in RULES.items():
        for match in pattern.finditer(plain):
            around = plain[max(0, match.start() - 25) : match.end() + 25]
            yield Fault(place, " ".join(around.split()), rule)


def check_areas() -> dict[str, list[Fault]]:
    """Return the faults of each area."""
    texts = {
        "studio": _studio(),
        "operations and commands": _strings("service/mcml_service/operations", "service/mcml_service/cli", "schemas")
        | _strings("service/mcml_service/settings.py"),
        "errors": _strings("service/mcml_service", "mcml"),
        "guides": {
            name: (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "docs/getting-started.md")
        },
        "pages": {
            str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
            for path in [*ROOT.glob("docs/**/*.md"), ROOT / "CONTRIBUTING.md", ROOT / "SECURITY.md"]
        },
        "docstrings": _docstrings("service/mcml_service", "mcml", "schemas"),
    }
    return {
        area: [fault for place, text in places.items() for fault in check_text(place, text)]
        for area, places in texts.items()
    }


def _studio() -> dict[str, str]:
    """The English of each table of words: of a panel, the first of its two tables."""
    sources = ROOT / "service/web/src"
    texts = {"words/en.ts": (sources / "words/en.ts").read_text(encoding="utf-8")}
    for path in sorted([*sources.glob("panels/*/words.ts"), *sources.glob("ui/*/words.ts")]):
        english = path.read_text(encoding="utf-8").partition("\n  {\n")[2].partition("\n  },\n")[0]
        texts[str(path.relative_to(sources))] = english
    return {place: "\n".join(re.findall(r': "((?:[^"\\]|\\.)*)"', text)) for place, text in texts.items()}


def _modules(*tops: str) -> Iterator[tuple[str, ast.Module]]:
    for top in tops:
        for path in [ROOT / top] if top.endswith(".py") else sorted((ROOT / top).rglob("*.py")):
            yield str(path.relative_to(ROOT)), _parse(path)


@cache
def _parse(path: Path) -> ast.Module:
    """A module, which several areas read."""
    return ast.parse(path.read_text(encoding="utf-8"))


def _strings(*tops: str) -> dict[str, str]:
    """The sentences in each module that are no docstrings, by place."""
    texts = {}
    for name, module in _modules(*tops):
        documented = {id(node.value) for node in ast.walk(module) if isinstance(node, ast.Expr)}
        constants = [node for node in ast.walk(module) if isinstance(node, ast.Constant)]
        for node in constants:
            if isinstance(node.value, str) and id(node) not in documented and SENTENCE.search(node.value):
                texts[f"{name}:{node.lineno}"] = node.value
    return texts


def _docstrings(*tops: str) -> dict[str, str]:
    return {
        f"{name}:{node.lineno}": node.value.value
        for name, module in _modules(*tops)
        for node in ast.walk(module)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    }


def main() -> int:
    """Print the faults of areas beyond their budget, and budgets that can be lowered. Return 1 if there are faults."""
    status = 0
    for area, faults in check_areas().items():
        budget = BUDGETS[area]
        if len(faults) > budget:
            status = 1
            print(f"{area}: {len(faults)} places, {budget} allowed")
            for fault in faults:
                print(f"  {fault.place}: …{fault.words}… ({fault.rule})")
        elif len(faults) < budget:
            print(f"{area}: {len(faults)} places, {budget} allowed: lower the budget in tests/docs/english.py")
    return status


if __name__ == "__main__":
    sys.exit(main())
