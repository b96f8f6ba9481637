"""Cells of CSV for spreadsheets: text that looks like a formula gets a leading apostrophe."""

from __future__ import annotations

import re

_FORMULA = re.compile(r"'*[=+\-@\t\r\n]")
"""Characters that begin a formula, as OWASP lists them (CSV Injection). Apostrophes before one are kept apart from the
one that is written."""
_ONE = r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|INF|inf)"
_NUMBERS = re.compile(rf"{_ONE}(?: {_ONE})*")
"""A number, or several, which no spreadsheet computes with."""


def safe_cell(text: str) -> str:
    """The text as a spreadsheet shows it and does not run it. Numbers stay numbers."""
    return f"'{text}" if _FORMULA.match(text) and not _NUMBERS.fullmatch(text) else text


def read_cell(cell: str) -> str:
    """The text that `safe_cell` was given."""
    return cell[1:] if cell.startswith("'") and _FORMULA.match(cell) else cell
