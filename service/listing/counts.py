"""What there is among documents of the columns, counted; `storage.facets` says the same in SQL."""

from __future__ import annotations

from collections.abc import Callable
from heapq import nsmallest
from typing import Any

import numpy as np

from service.listing.columns import Column, Columns, Numbers
from service.listing.vocabulary import Mask, Vocabulary
from service.storage.facets import Bins, Counts, Facets, PropertyFacet, binned, rate_of


def facets_of(
    columns: Columns, among: Mask, joints: Callable[[list[int]], dict[int, int]], most: int, bins: int
) -> Facets:
    """Of some of the documents. most: values of each facet. bins: of each range of numbers. joints: of skeletons."""
    words = columns.words
    skeletons, skeleton_codes = columns.once("skeletons", lambda: _distinct(columns["skeletons"]))
    seconds, second_codes = columns.once("seconds", lambda: _distinct(columns["seconds"]))
    lengths, length_codes = columns.once("lengths", lambda: _distinct(columns["frames"] * columns["seconds"]))
    is_known = ~np.isnan(seconds)
    of_seconds = _counted(second_codes, among, len(seconds))
    rates: dict[float, int] = {}
    for each, count in zip(seconds[is_known].tolist(), of_seconds[is_known].tolist(), strict=True):
        if count:
            rates[rate_of(each)] = rates.get(rate_of(each), 0) + count
    shown = _most(_counted(skeleton_codes, among, len(skeletons)), skeletons.tolist().__getitem__, most)
    joints_of = joints([key for key, _ in shown])
    return Facets(
        total=int(np.count_nonzero(among)),
        projects=_most_texts(words.projects, _counted(columns["projects"], among, len(words.projects)), most),
        formats=_most_texts(words.formats, _counted(columns["formats"], among, len(words.formats)), most),
        skeletons=[((key, joints_of[key]), count) for key, count in shown],
        motion_names=_most_texts(words.texts, columns.named.counts(among, len(words.texts)), most),
        lengths=_binned(lengths, _counted(length_codes, among, len(lengths)), bins),
        rates=sorted(rates.items(), key=lambda item: (-item[1], item[0]))[:most],
        unknown=int(of_seconds[~is_known].sum()),
        properties=_properties(columns, among, most, bins),
    )


def _distinct(values: Column) -> tuple[Column, Column]:
    """The different values in order, and which of them each document has. NaN is one value, the last."""
    found, codes = np.unique(values, return_inverse=True)
    return found, codes.astype(np.int32)


def _counted(codes: Column, among: Mask, count: int) -> Numbers:
    return np.bincount(codes if among.all() else codes[among], minlength=count)


def _most_texts(vocabulary: Vocabulary[str], counts: Numbers, most: int) -> Counts:
    return _most(counts, vocabulary.values.__getitem__, most)


def _most(counts: Numbers, value: Callable[[int], Any], most: int) -> Counts:
    """(value, count) of the codes that occur, the most frequent first; those as frequent by their order."""
    codes = np.flatnonzero(counts)
    if len(codes) > most:
        # Only those that may be among them are looked at one by one.
        least = np.partition(counts[codes], len(codes) - most)[len(codes) - most]
        codes = codes[counts[codes] >= least]
    found = ((-int(counts[code]), value(code)) for code in codes.tolist())
    return [(one, -count) for count, one in nsmallest(most, found)]


def _properties(columns: Columns, among: Mask, most: int, bins: int) -> list[PropertyFacet]:
    properties = columns.words.properties
    names, numbers, is_short = columns.properties
    counts = columns.having.counts(among, len(names)) * is_short
    is_number = ~np.isnan(numbers)
    totals = np.bincount(names, counts, len(properties.names)).astype(np.int64)
    found = []
    for name, total in _most_texts(properties.names, totals, most):
        its_own = (names == properties.names.code(name)) & (counts > 0)
        of_numbers = np.flatnonzero(its_own & is_number)
        texts = np.where(its_own & ~is_number, counts, 0)
        found.append(
            PropertyFacet(
                name,
                total,
                _binned(numbers[of_numbers], counts[of_numbers], bins),
                _most(texts, lambda code: properties.values[code][2], most),
            )
        )
    return found


def _binned(values: Column, counts: Numbers, bins: int) -> Bins | None:
    """Bins of values that occur so often."""
    has = (counts > 0) & ~np.isnan(values)
    return binned(values[has], bins, counts[has])
