"""The figures of the XPath benchmark beside what is wanted."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan

from benchmarks.xpath_library import SIZES
from benchmarks.xpath_questions import WANTED, WANTED_AFTER_EDIT, Question

RESOLUTION = 0.05
"""Milliseconds below which a difference of two medians says nothing; a shorter time counts as this in ratios."""

GROWTH = 1.5
SLOWER = 1.0
MEMORY = 150.0


@dataclass
class Row:
    """Milliseconds by size, net of an empty request; lxml's and PostgreSQL's as they are."""

    question: Question
    ours: dict[int, float] = field(default_factory=dict)
    basex: dict[int, float] = field(default_factory=dict)
    ours_edited: dict[int, float] = field(default_factory=dict)
    basex_edited: dict[int, float] = field(default_factory=dict)
    lxml: dict[int, float] = field(default_factory=dict)
    postgres: float = nan
    memory: dict[int, float] = field(default_factory=dict)


def print_table(rows: list[Row], idle: dict[int, float]) -> dict[str, object]:
    """Print a table in Markdown, its misses below it; returns the figures."""
    small, _, large = SIZES
    print()
    print(
        f"| question | ours ms, {small} / {SIZES[1]} / {large} | BaseX ms, {small} / {SIZES[1]} / {large} "
        f"| BaseX / ours, {large} | wanted | lxml ms, {large} | PostgreSQL ms, {small} | MB over idle |"
    )
    print("|---|---|---|---|---|---|---|---|")
    misses = []
    figures: dict[str, object] = {f"idle_MB_{size}": value for size, value in idle.items()}
    for row in rows:
        wanted = WANTED[row.question.kind]
        ratio = _ratio(row.ours, row.basex, large)
        _print(row, row.question.name, row.ours, row.basex, wanted)
        misses += _misses(row, ratio, wanted)
        figures[row.question.name] = {
            "ours_ms": _named(row.ours),
            "basex_ms": _named(row.basex),
            "basex_to_ours": ratio,
            "lxml_ms": _named(row.lxml),
            "postgres_ms": row.postgres,
            "memory_MB": _named(row.memory),
        }
        if row.ours_edited:
            after = _ratio(row.ours_edited, row.basex_edited, large)
            _print(row, f"{row.question.name}, after an edit", row.ours_edited, row.basex_edited, WANTED_AFTER_EDIT)
            if after < WANTED_AFTER_EDIT:
                misses.append(f"{row.question.name}, after an edit: {after:.3g} times, wanted {WANTED_AFTER_EDIT:g}")
            figures[f"{row.question.name}, after an edit"] = {
                "ours_ms": _named(row.ours_edited),
                "basex_ms": _named(row.basex_edited),
                "basex_to_ours": after,
            }
    print()
    print("| answer of one size | ours ms, 5 | 25 | 100 | 100 / 5 |")
    print("|---|---|---|---|---|")
    for row in rows:
        if row.question.same_size:
            cells = [f"{row.ours[size]:.2f}" for size in SIZES]
            print(f"| {row.question.name} | {' | '.join(cells)} | {_growth(row):.2f} |")
    print()
    for miss in misses:
        print(f"   missed: {miss}")
    return figures


def _print(row: Row, name: str, ours: dict[int, float], basex: dict[int, float], wanted: float) -> None:
    edited = ours is row.ours_edited
    ratio = _ratio(ours, basex, max(SIZES))
    cells = [
        name,
        " / ".join(f"{ours[size]:.3g}" for size in SIZES),
        " / ".join(f"{basex[size]:.3g}" for size in SIZES) if basex else "",
        f"{ratio:.3g}",
        f"{wanted:g}" if wanted else f"<= {SLOWER:g} ms slower",
        "" if edited else f"{row.lxml[max(SIZES)]:.3g}",
        "" if edited else f"{row.postgres:.3g}",
        "" if edited else f"{max(row.memory.values()):.0f}",
    ]
    print(f"| {' | '.join(cells)} |")


def _misses(row: Row, ratio: float, wanted: float) -> list[str]:
    name, large = row.question.name, max(SIZES)
    found = []
    if row.basex and ratio < wanted:
        found.append(f"{name}: {ratio:.3g} times, wanted {wanted:g}")
    if row.basex and row.ours[large] - row.basex[large] > SLOWER:
        found.append(f"{name}: {row.ours[large] - row.basex[large]:.3g} ms slower than BaseX, allowed {SLOWER:g}")
    if row.question.same_size and _growth(row) > GROWTH:
        found.append(f"{name}: takes {_growth(row):.3g} times as long with {large} documents as with {min(SIZES)}")
    if max(row.memory.values()) > MEMORY:
        found.append(f"{name}: {max(row.memory.values()):.0f} MB over idle, allowed {MEMORY:g}")
    return found


def _growth(row: Row) -> float:
    return max(row.ours[max(SIZES)], RESOLUTION) / max(row.ours[min(SIZES)], RESOLUTION)


def _ratio(ours: dict[int, float], basex: dict[int, float], size: int) -> float:
    return max(basex[size], RESOLUTION) / max(ours[size], RESOLUTION) if size in basex else nan


def _named(values: dict[int, float]) -> dict[str, float]:
    return {str(size): value for size, value in values.items()}
