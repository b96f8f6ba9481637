"""Facets of documents: values by which a list can be filtered, with counts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Select, func, select

from mcml_service.storage.core.tables import content, document, project, property_, skeleton, span
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.lists.filtering import SHORT, DocumentFilter, seconds, select_wanted

Numbers = NDArray[np.float64]
Counts = list[tuple[Any, int]]
"""(value, documents), the most frequent first."""


FAR = 50.0
"""Times the smallest number: beyond it bins are of equal ratio."""


@dataclass(frozen=True)
class Bins:
    """Numbers of documents. edges: of the bins, one more than counts; the last one is included."""

    edges: list[float]
    counts: list[int]


@dataclass(frozen=True)
class PropertyFacet:
    """bins: of values that are numbers, None where none is. texts: the other values."""

    name: str
    documents: int
    bins: Bins | None
    texts: Counts


@dataclass(frozen=True)
class Facets:
    """rates: frames a second, rounded. skeletons: ((number, joints), documents). unknown: documents without length."""

    total: int
    projects: Counts
    formats: Counts
    skeletons: Counts
    motion_names: Counts
    lengths: Bins | None = None
    rates: Counts = field(default_factory=list)
    unknown: int = 0
    properties: list[PropertyFacet] = field(default_factory=list)


def facets(tx: BaseTransaction, wanted: DocumentFilter, most: int, bins: int) -> Facets:
    """Of the documents that are wanted. most: values of each facet. bins: of each range of numbers."""
    motion = select(span.c.name, func.count(span.c.document.distinct())).where(
        span.c.document.in_(select_wanted(document.c.id, wanted, tx)), tx.valid(span)
    )
    skeletons = select_wanted(content.c.skeleton, wanted, tx)
    sizes = select(skeleton.c.id, skeleton.c.joints).where(skeleton.c.id.in_(skeletons))
    joints = {row.id: row.joints for row in tx.fetch_all(sizes)}
    timing = select_wanted(content.c.frames, wanted, tx).add_columns(seconds(tx.at))
    lengths, rates, unknown = [], [], 0
    for frames, each in tx.fetch_all(timing):
        if each is None:
            unknown += 1
        else:
            lengths.append(frames * each)
            rates.append(rate_of(each))
    return Facets(
        total=len(lengths) + unknown,
        projects=_count(tx, select_wanted(project.c.name, wanted, tx), project.c.name, most),
        formats=_count(tx, select_wanted(document.c.format, wanted, tx), document.c.format, most),
        skeletons=[((key, joints[key]), count) for key, count in _count(tx, skeletons, content.c.skeleton, most)],
        motion_names=_most(tx.fetch_all(motion.group_by(span.c.name)), most),
        lengths=make_bins(lengths, bins),
        rates=_most(Counter(rates).items(), most),
        unknown=unknown,
        properties=_properties(tx, wanted, most, bins),
    )


def rate_of(seconds: float) -> float:
    """Frames a second, as facets count them."""
    return round(1 / seconds) or round(1 / seconds, 3)


def _count(tx: BaseTransaction, query: Select[Any], column: Any, most: int) -> Counts:
    return _most(tx.fetch_all(query.add_columns(func.count()).group_by(column)), most)


def _most(found: Iterable[Any], most: int) -> Counts:
    """The most frequent values; those as frequent by their order."""
    return sorted(((value, int(count)) for value, count in found), key=lambda item: (-item[1], item[0]))[:most]


def _properties(tx: BaseTransaction, wanted: DocumentFilter, most: int, bins: int) -> list[PropertyFacet]:
    """Return properties by their number of documents, except records of programs, which are too long for filters."""
    query = select(property_.c.name, property_.c.number, property_.c.text).where(
        property_.c.document.in_(select_wanted(document.c.id, wanted, tx)), func.length(property_.c.text) <= SHORT
    )
    numbers: dict[str, list[float]] = {}
    texts: dict[str, Counter[str]] = {}
    for name, number, text in tx.fetch_all(query):
        if number is not None:
            numbers.setdefault(name, []).append(number)
        else:
            texts.setdefault(name, Counter())[text] += 1
    property_facets = [
        PropertyFacet(
            name,
            len(numbers.get(name, ())) + sum(texts.get(name, Counter()).values()),
            make_bins(numbers.get(name, []), bins),
            _most(texts.get(name, Counter()).items(), most),
        )
        for name in numbers.keys() | texts.keys()
    ]
    return sorted(property_facets, key=lambda facet: (-facet.documents, facet.name))[:most]


def make_bins(given: Sequence[float] | Numbers, bins: int, times: NDArray[np.int64] | None = None) -> Bins | None:
    """Bins of equal width from the least to the greatest; of equal ratio if numbers, none below 0, have very
    different sizes, so that few large ones do not put all others into one bin (zeros are in the first). One bin if
    all are equal, None without numbers. times: number of occurrences of each value, default one.
    """
    values = np.asarray(given, np.float64)
    if not len(values):
        return None
    if times is None:
        times = np.ones(len(values), np.int64)
    least, greatest = float(values.min()), float(values.max())
    if not np.isfinite(greatest - least) or greatest - least <= 1e-12 * max(abs(least), abs(greatest)):
        return Bins([least, greatest], [int(times.sum())])
    smallest = float(np.min(values, where=values > 0, initial=greatest))
    if least >= 0 and greatest > FAR * smallest:
        wanted = np.geomspace(smallest, greatest, bins + 1)
        wanted[0], wanted[-1] = least, greatest
    else:
        wanted = np.linspace(least, greatest, bins + 1)
    order = np.argsort(values)
    upto = np.concatenate([[0], np.cumsum(times[order])])
    ends = np.searchsorted(values[order], wanted[:-1]).tolist()
    return Bins(wanted.tolist(), np.diff(upto[[*ends, len(values)]]).tolist())
