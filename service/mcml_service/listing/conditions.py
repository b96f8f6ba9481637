"""Filter documents of the columns by the conditions of a list; `storage.filtering` does the same in SQL."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcml_service.listing.columns import Column, Columns
from mcml_service.listing.vocabulary import Mask
from mcml_service.storage.core.identifiers import normalise_name
from mcml_service.storage.lists.filtering import SHORT, DocumentFilter, Range

KEPT = 16
"""Number of conditions with cached matches: a page, the next page and the counts use the same conditions."""


def can_tell(wanted: DocumentFilter) -> bool:
    """Whether columns have what the conditions are about: long texts of properties they have not."""
    return all(text is None or len(text) <= SHORT for _, _, _, text in wanted.properties)


def fulfilling(columns: Columns, wanted: DocumentFilter) -> Mask:
    """Which documents fulfil all of the conditions."""
    known = columns.once("fulfilling", dict)
    mask: Mask | None = known.get(wanted)
    if mask is None:
        mask = _fulfilling(columns, wanted)
        if len(known) >= KEPT:
            known.clear()
        known[wanted] = mask
    return mask


def _fulfilling(columns: Columns, wanted: DocumentFilter) -> Mask:
    words, count = columns.words, len(columns)
    mask = ~columns["there"] if wanted.deleted else columns["there"].copy()
    if wanted.project is not None:
        mask &= columns["projects"] == _code(words.projects.code(normalise_name(wanted.project)))
    if wanted.format is not None:
        mask &= columns["formats"] == _code(words.formats.code(wanted.format))
    if wanted.skeleton is not None:
        mask &= columns["skeletons"] == wanted.skeleton
    if wanted.name is not None:
        mask &= columns["names"] == normalise_name(wanted.name)
    if wanted.id is not None:
        mask &= _begins(columns["uuids"], wanted.id.lower())
    for word in (wanted.text or "").split():
        holding = columns.said.having(words.texts.holding(word), count)
        holding |= columns.named.having(words.texts.holding(word), count)
        mask &= holding | columns.having.having(words.properties.holding(word), count)
    if wanted.motion_name is not None:
        named = columns.named.codes == _code(words.texts.code(normalise_name(wanted.motion_name)))
        mask &= _mark(columns.named.places[named], count)
    for condition in wanted.properties:
        mask &= columns.having.having(_properties(columns, *condition), count)
    if wanted.among is not None:
        mask &= np.isin(columns["keys"], np.array(wanted.among, np.int64))
    mask &= _within(columns["frames"] * columns["seconds"], wanted.length)
    mask &= _within(1.0 / columns["seconds"], wanted.rate)
    return mask


def _code(code: int | None) -> int:
    return -1 if code is None else code


def _mark(places: Column, count: int) -> Mask:
    mask = np.zeros(count, np.bool_)
    mask[places] = True
    return mask


def _begins(uuids: Column, beginning: str) -> Mask:
    codes = np.frombuffer(beginning.encode(), np.uint8)
    width = uuids.dtype.itemsize
    if len(codes) > width:
        return np.zeros(len(uuids), np.bool_)
    letters = uuids.view(np.uint8).reshape(len(uuids), width)[:, : len(codes)]
    return np.asarray((letters == codes).all(axis=1))


def _properties(columns: Columns, name: str, least: float | None, greatest: float | None, text: str | None) -> Mask:
    """Which different properties fulfil a condition."""
    properties = columns.words.properties
    names, numbers, _ = columns.properties
    mask: Mask = names == _code(properties.names.code(name))
    if text is not None:
        mask &= np.fromiter((value[2] == text for value in properties.values[: len(names)]), np.bool_, len(names))
    return mask & _within(numbers, (least, greatest))


def _within(values: Any, bounds: Range) -> Mask | np.bool_:
    least, greatest = bounds
    mask: Mask | np.bool_ = np.True_
    # Unknown values, NaN, are outside all bounds.
    if least is not None:
        mask = mask & (values >= least)
    if greatest is not None:
        mask = mask & (values <= greatest)
    return mask
