"""Quantities of the body of a document (`height:left_hand`) as columns of numbers, for some of its frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from service.actions.reading.read_numbers import Numbers
from service.clips.bodies import Body, read_turned
from service.errors import NotFoundError
from service.motion.bodies.limb_angles import turn_named
from service.motion.bodies.quantities import compute, halo_of, joints_of, quantity_of
from service.motion.bodies.stretch import known
from service.motion.skeleton import Array
from service.storage.documents import StoredDocument
from service.storage.transaction import Transaction


@dataclass(frozen=True)
class Asked:
    """text: as it was asked, NAME:ARGUMENT,ARGUMENT. unit: "m", "m/s", "m/s2", "s", "deg" or ""."""

    text: str
    name: str
    arguments: tuple[str, ...]
    unit: str


def asked_quantity(text: str) -> Asked:
    """What `speed:right_hand,Root` asks for. RequestError or VocabularyError, with what there is, for what is none."""
    name, _, rest = text.partition(":")
    arguments = tuple(part.strip() for part in rest.split(",")) if rest else ()
    quantity = quantity_of(name.strip(), arguments)
    quantity.joints(arguments)
    return Asked(text, name.strip(), arguments, quantity.unit)


def quantity_columns(
    tx: Transaction, stored: StoredDocument, body: Body, asked: Sequence[Asked], first: int, last: int
) -> Array:
    """(frames first to last, quantities), positions from 1, float64; NaN where unknown.

    Only as many frames around these are looked at as give the values of the whole document. NotFoundError for joints
    that the document has not.
    """
    found = np.empty((max(0, last - first + 1), len(asked)))
    for place, one in enumerate(asked):
        _check_joints(one, body)
        if one.name == "angle" and len(one.arguments) == 1 and turn_named(one.arguments[0]) is not None:
            found[:, place] = read_turned(tx, stored, one.arguments[0], body)[first - 1 : last]
        else:
            found[:, place] = _stretch(one, body, first, last)
    return found


def _stretch(asked: Asked, body: Body, first: int, last: int) -> Array:
    halo = halo_of(asked.name, asked.arguments, body.frame_time)
    low = 0 if halo is None else max(0, first - 1 - halo)
    high = body.frames if halo is None else min(body.frames, last + halo)
    stretch = body.stretch(joints_of(asked.name, asked.arguments, body.names), low, high)
    values: Array = compute(asked.name, asked.arguments, stretch)[first - 1 - low : last - low]
    return values


def _check_joints(asked: Asked, body: Body) -> None:
    needs = quantity_of(asked.name, asked.arguments).joints(asked.arguments)
    lacking = [one for one in needs if known(one, body.names) is None]
    if lacking:
        raise NotFoundError(
            f"The document has no bone {lacking[0]!r}, which {asked.text} is made from.",
            remedy=f"It has: {', '.join(body.names[:60])}.",
        )


def with_quantities(numbers: Numbers, asked: Sequence[Asked], values: Array, *, alone: bool) -> Numbers:
    """Channels of frames with quantities (frames, quantities) after them. alone: without the channels."""

    def blocks() -> Iterator[tuple[Array, NDArray[np.int64] | list[str]]]:
        done = 0
        for channels, ids in numbers.blocks():
            part = values[done : done + len(channels)]
            done += len(channels)
            yield part if alone else np.concatenate([channels, part], axis=1), ids

    columns = [] if alone else numbers.columns
    units = [*[""] * len(columns), *(one.unit for one in asked)]
    columns = [*columns, *(one.text for one in asked)]
    return replace(numbers, columns=columns, shape=(len(columns),), blocks=blocks, units=units)
