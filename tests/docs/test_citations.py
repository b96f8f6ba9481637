"""Documents that code and tests cite are in the repository."""

from __future__ import annotations

import re

from tests.docs.english import ROOT

CITED = re.compile(r"[\w./-]+\.md\b")
MADE = {"docs/formats/plain.md"}
"""Made by a drill."""
SOURCES = [
    path
    for top in ("service/mcml_service", "mcml", "schemas", "tests", "benchmarks", "integrations", "service/web/src")
    for pattern in ("*.py", "*.ts", "*.tsx")
    for path in (ROOT / top).rglob(pattern)
]


def test_cited_documents_exist() -> None:
    missing = [
        (str(path.relative_to(ROOT)), name)
        for path in SOURCES
        for name in CITED.findall(path.read_text(encoding="utf-8"))
        if "/" in name and not name.startswith(("/", ".")) and name not in MADE and not (ROOT / name).is_file()
    ]
    assert not missing


def test_documents_are_cited_by_their_path() -> None:
    """A bare name with the number of a section is of a document that nobody has."""
    bare = [
        (str(path.relative_to(ROOT)), match.group())
        for path in SOURCES
        for match in re.finditer(r"(?<![/\w])\w+\.md,? \d[\d.]*", path.read_text(encoding="utf-8"))
    ]
    assert not bare
