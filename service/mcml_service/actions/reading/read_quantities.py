"""Quantities of the body of a document (`height:left_hand`) as columns of numbers, for some of its frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mcml.files.read_numbers import Numbers
from mcml.motion.bodies.quantities import AskedQuantity, compute, halo_of
from mcml.motion.skeleton import Array
from mcml_service.clips.bodies import Body
from mcml_service.clips.frame_quantities import FrameQuantities, is_beside_positions


def quantity_columns(source: FrameQuantities, asked: Sequence[AskedQuantity], first: int, last: int) -> Array:
    """(frames first to last, quantities), positions from 1, float64; NaN where unknown.

    Only as many frames around these are looked at as give the values of the whole document. NotFoundError for joints
    and measurements that the document has not.
    """
    values = np.empty((max(0, last - first + 1), len(asked)))
    for place, quantity in enumerate(asked):
        quantity.check_joints(source.body.names)
        if is_beside_positions(quantity):
            values[:, place] = source.read(quantity)[first - 1 : last]
        else:
            values[:, place] = _stretch(quantity, source.body, first, last)
    return values


def _stretch(asked: AskedQuantity, body: Body, first: int, last: int) -> Array:
    halo = halo_of(asked.name, asked.arguments, body.frame_time)
    low = 0 if halo is None else max(0, first - 1 - halo)
    high = body.frames if halo is None else min(body.frames, last + halo)
    stretch = body.stretch(asked.joints(body.names), low, high)
    values: Array = compute(asked.name, asked.arguments, stretch)[first - 1 - low : last - low]
    return values


def with_quantities(
    numbers: Numbers, asked: Sequence[AskedQuantity], own: Sequence[str], values: Array, *, alone: bool
) -> Numbers:
    """Channels of frames with quantities (frames, quantities) after them. own: units of these. alone: without the
    channels."""

    def blocks() -> Iterator[tuple[Array, NDArray[np.int64] | list[str]]]:
        done = 0
        for channels, ids in numbers.blocks():
            part = values[done : done + len(channels)]
            done += len(channels)
            yield part if alone else np.concatenate([channels, part], axis=1), ids

    columns = [] if alone else numbers.columns
    units = [*[""] * len(columns), *own]
    columns = [*columns, *(quantity.text for quantity in asked)]
    return replace(numbers, columns=columns, shape=(len(columns),), blocks=blocks, units=units)
