"""Which documents of the columns fulfil the conditions of a list; `storage.filtering` says the same in SQL."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcml_service.listing.columns import Column, Columns
from mcml_service.listing.vocabulary import Mask
from mcml_service.storage.core.identifiers import normalise_name
from mcml_service.storage.lists.filtering import SHORT, DocumentFilter, Range

KEPT = 16
"""Conditions of which it is kept who fulfils them: a page, the next one and the counts are asked with the same."""


def can_tell(wanted: DocumentFilter) -> bool:
    """Whether columns have what the conditions are about: long texts of properties they have not."""
    return all(text is None or len(text) <= SHORT for _, _, _, text in wanted.properties)


def fulfilling(columns: Columns, wanted: DocumentFilter) -> Mask:
    """Which documents fulfil all of the conditions."""
    known = columns.once("fulfilling", dict)
    found: Mask | None = known.get(wanted)
    if found is None:
        found = _fulfilling(columns, wanted)
        if len(known) >= KEPT:
            known.clear()
        known[wanted] = found
    return found


def _fulfilling(columns: Columns, wanted: DocumentFilter) -> Mask:
    words, count = columns.words, len(columns)
    found = ~columns["there"] if wanted.deleted else columns["there"].copy()
    if wanted.project is not None:
        found &= columns["projects"] == _code(words.projects.code(normalise_name(wanted.project)))
    if wanted.format is not None:
        found &= columns["formats"] == _code(words.formats.code(wanted.format))
    if wanted.skeleton is not None:
        found &= columns["skeletons"] == wanted.skeleton
    if wanted.name is not None:
        found &= columns["names"] == normalise_name(wanted.name)
    if wanted.id is not None:
        found &= _begins(columns["uuids"], wanted.id.lower())
    for word in (wanted.text or "").split():
        holding = columns.said.having(words.texts.holding(word), count)
        holding |= columns.named.having(words.texts.holding(word), count)
        found &= holding | columns.having.having(words.properties.holding(word), count)
    if wanted.motion_name is not None:
        named = columns.named.codes == _code(words.texts.code(normalise_name(wanted.motion_name)))
        found &= _mark(columns.named.places[named], count)
    for condition in wanted.properties:
        found &= columns.having.having(_properties(columns, *condition), count)
    if wanted.among is not None:
        found &= np.isin(columns["keys"], np.array(wanted.among, np.int64))
    found &= _within(columns["frames"] * columns["seconds"], wanted.length)
    found &= _within(1.0 / columns["seconds"], wanted.rate)
    return found


def _code(code: int | None) -> int:
    return -1 if code is None else code


def _mark(places: Column, count: int) -> Mask:
    found = np.zeros(count, np.bool_)
    found[places] = True
    return found


def _begins(uuids: Column, beginning: str) -> Mask:
    said = np.frombuffer(beginning.encode(), np.uint8)
    width = uuids.dtype.itemsize
    if len(said) > width:
        return np.zeros(len(uuids), np.bool_)
    letters = uuids.view(np.uint8).reshape(len(uuids), width)[:, : len(said)]
    return np.asarray((letters == said).all(axis=1))


def _properties(columns: Columns, name: str, least: float | None, greatest: float | None, text: str | None) -> Mask:
    """Which different properties fulfil a condition."""
    properties = columns.words.properties
    names, numbers, _ = columns.properties
    found: Mask = names == _code(properties.names.code(name))
    if text is not None:
        found &= np.fromiter((value[2] == text for value in properties.values[: len(names)]), np.bool_, len(names))
    return found & _within(numbers, (least, greatest))


def _within(values: Any, bounds: Range) -> Mask | np.bool_:
    least, greatest = bounds
    found: Mask | np.bool_ = np.True_
    # What is unknown, NaN, is within no bounds.
    if least is not None:
        found = found & (values >= least)
    if greatest is not None:
        found = found & (values <= greatest)
    return found
