"""Counts of values among documents of the columns; `storage.facets` does the same in SQL."""

from __future__ import annotations

from collections.abc import Callable
from heapq import nsmallest
from typing import Any

import numpy as np

from mcml_service.listing.columns import Column, Columns, Numbers
from mcml_service.listing.vocabulary import Mask, Numbering
from mcml_service.storage.lists.facets import Bins, Counts, Facets, PropertyFacet, make_bins, rate_of


def facets_of(
    columns: Columns, among: Mask, joints: Callable[[list[int]], dict[int, int]], most: int, bins: int
) -> Facets:
    """Of some of the documents. most: values of each facet. bins: of each range of numbers. joints: of skeletons."""
    words = columns.words
    of_seconds = _count(columns["codes of seconds"], among, words.seconds)
    rates: dict[float, int] = {}
    for code in np.flatnonzero(of_seconds).tolist():
        each = words.seconds.values[code]
        if each is not None:
            rates[rate_of(each)] = rates.get(rate_of(each), 0) + int(of_seconds[code])
    of_lengths = _count(columns["codes of lengths"], among, words.lengths)
    lengths = np.array(words.lengths.values[: len(of_lengths)], np.float64)
    shown = _most(words.skeletons, _count(columns["codes of skeletons"], among, words.skeletons), most)
    joints_of = joints([key for key, _ in shown])
    total = int(np.count_nonzero(among))
    return Facets(
        total=total,
        projects=_most(words.projects, _count(columns["projects"], among, words.projects), most),
        formats=_most(words.formats, _count(columns["formats"], among, words.formats), most),
        skeletons=[((key, joints_of[key]), count) for key, count in shown],
        motion_names=_most(words.texts, columns.named.counts(among, len(words.texts)), most),
        lengths=_make_bins(lengths, of_lengths, bins),
        rates=sorted(rates.items(), key=lambda item: (-item[1], item[0]))[:most],
        unknown=total - sum(rates.values()),
        properties=_properties(columns, among, most, bins),
    )


def _count(codes: Column, among: Mask, numbering: Numbering[Any]) -> Numbers:
    """How many documents have each of the values."""
    return np.bincount(codes if among.all() else codes[among], minlength=len(numbering))


def _most(numbering: Numbering[Any], counts: Numbers, most: int) -> Counts:
    """(value, count) of the values that occur, the most frequent first; those as frequent by their order."""
    codes = np.flatnonzero(counts)
    if len(codes) > most:
        # Only candidates are compared one by one.
        least = np.partition(counts[codes], len(codes) - most)[len(codes) - most]
        codes = codes[counts[codes] >= least]
    most_common = ((-int(counts[code]), numbering.values[code]) for code in codes.tolist())
    return [(value, -count) for count, value in nsmallest(most, most_common)]


def _properties(columns: Columns, among: Mask, most: int, bins: int) -> list[PropertyFacet]:
    properties = columns.words.properties
    names, numbers, is_short = columns.properties
    counts = columns.having.counts(among, len(names)) * is_short
    is_number = ~np.isnan(numbers)
    totals = np.bincount(names, counts, len(properties.names)).astype(np.int64)
    facets = []
    for name, total in _most(properties.names, totals, most):
        its_own = (names == properties.names.code(name)) & (counts > 0)
        of_numbers = np.flatnonzero(its_own & is_number)
        texts = np.where(its_own & ~is_number, counts, 0)
        facets.append(
            PropertyFacet(
                name,
                total,
                _make_bins(numbers[of_numbers], counts[of_numbers], bins),
                [(value[2], count) for value, count in _most(properties, texts, most)],
            )
        )
    return facets


def _make_bins(values: Column, counts: Numbers, bins: int) -> Bins | None:
    """Bins of values that occur so often."""
    has = (counts > 0) & ~np.isnan(values)
    return make_bins(values[has], bins, counts[has])
