"""The documentation is complete and true: tables from catalogues, settings, formats, links."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from mcml.formats import READERS, WRITERS
from mcml_service.settings import Settings
from tests.docs import signatures
from tests.docs.generate import DOCS, PAGES, TABLES, renewed


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_generated_tables_are_fresh(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert renewed(text) == text, "run `make docs`"


def test_python_knows_the_operations_that_there_are() -> None:
    for path, text in signatures.made().items():
        kept = path.read_text(encoding="utf-8")
        # The stub is laid out by ruff.
        same = kept == text if path.suffix == ".json" else ast.dump(ast.parse(kept)) == ast.dump(ast.parse(text))
        assert same, f"{path.name}: run `make docs`"


def test_every_table_is_shown() -> None:
    shown = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for name in TABLES:
        assert f"<!-- generated: {name} -->" in shown


def test_every_setting_is_explained() -> None:
    text = (DOCS / "settings.md").read_text(encoding="utf-8")
    for name in Settings.model_fields:
        assert f"`MCML_{name.upper()}`" in text, name


def test_every_format_has_its_page() -> None:
    for name in [*READERS, "mcml"]:
        assert (DOCS / "formats" / f"{name}.md").is_file(), name
    pages = [page.read_text(encoding="utf-8") for page in (DOCS / "formats").iterdir()]
    for name in WRITERS.keys() - READERS:
        assert any(f"`{name}`" in page and "ritten" in page for page in pages), name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), target
