"""The guides for people who join name files, functions and words that exist."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
GUIDES = (
    "CONTRIBUTING.md",
    "SECURITY.md",
    "README.md",
    "docs/glossary.md",
    "docs/security.md",
    "service/mcml_service/xpath/README.md",
)
ROWS = re.findall(r"^\| (?!word )([^|-][^|]*) \| [^|]+ \| `([^`]+)` \|$", (ROOT / "docs/glossary.md").read_text(), re.M)


@pytest.mark.parametrize("guide", GUIDES)
def test_what_a_guide_names_is_there(guide: str) -> None:
    """A page of a folder in the service names them from there."""
    text = (ROOT / guide).read_text()
    base = (ROOT / guide).parent if guide.startswith("service/") else ROOT
    folders = "|".join(path.name for path in base.iterdir() if path.is_dir() and not path.name.startswith("."))
    for path, name in re.findall(rf"`((?:{folders})/[\w/.]*)(?:: (\w+))?", text):
        assert (base / path).exists(), path
        if name:
            body = ast.parse((base / path).read_text()).body
            defined = {node.name for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
            named = (node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)] for node in body)
            assert name in defined | {getattr(target, "id", None) for targets in named for target in targets}, name


@pytest.mark.parametrize("guide", GUIDES)
def test_links_of_a_guide_lead_somewhere(guide: str) -> None:
    for link in re.findall(r"\]\((?!http)([^)#]+)", (ROOT / guide).read_text()):
        assert ((ROOT / guide).parent / link).exists(), link


@pytest.mark.parametrize(("words", "place"), ROWS)
def test_words_of_the_glossary_are_used_where_it_says(words: str, place: str) -> None:
    path = ROOT / place
    files = [path] if path.is_file() else list(path.rglob("*.py"))
    text = " ".join(file.read_text() for file in files).lower() + path.stem
    for word in re.sub(r" \(.*\)", "", words).split(", "):
        assert word in text, word


def test_the_glossary_was_read() -> None:
    assert len(ROWS) > 40
