"""Measurements of a file beside the motion, such as the angles and moments of a laboratory's own model.

The values are those of the file: edits of the motion do not change them. They belong to frames by the numbers that the
frames have in the file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import NotFoundError
from mcml.formats.c3d.quantities import Quantity, kept_quantities, rate_of, samples_at
from mcml.motion.bodies.quantities import AXES_OF_FILE, AskedQuantity
from mcml.motion.clip import ClipHead
from mcml.motion.skeleton import Array

BEYOND_CAPTURES: Final = 10_000_000
"""Ids of frames that are of no file are larger: 28 hours at 100 Hz."""

NAMED: Final = 60
"""Limit of names in an error."""


def has_capture_numbers(head: ClipHead) -> bool:
    """Whether the ids of frames are the numbers that the frames have in the file, from which measurements are told."""
    return any(source.part == "c3d" for source in head.sources)


@dataclass(frozen=True)
class Measurement:
    """function: that asks for it, such as "quantity". name: its first argument, as the file writes it.

    axes: values of its second argument. unit: as the file writes it, "" where it does not state it. group: such as
    "ANGLES". rate: samples a second, None for one a frame. known: whether frames of the clip may have values; reason:
    why not.
    """

    function: str
    name: str
    axes: tuple[str, ...]
    unit: str
    group: str
    rate: float | None = None
    known: bool = True
    reason: str = ""


class Measurements:
    """The measurements of the file of a clip. head: of the clip."""

    def __init__(self, head: ClipHead) -> None:
        self._head = head

    def list(self) -> list[Measurement]:
        """Every measurement, in the order of the file."""
        rate = rate_of(self._head)
        return [
            Measurement(
                "quantity",
                label,
                AXES_OF_FILE,
                quantity.unit,
                quantity.group,
                known=known,
                reason=""
                if known
                else f"the file has {quantity.rate} frames a second, the document {rate or 'no rate'}",
            )
            for label, quantity in self._quantities.items()
            for known in [quantity.has_rate(rate)]
        ]

    def values(self, asked: AskedQuantity, ids: NDArray[np.int64] | Sequence[str]) -> Array:
        """(n,) of the frames with these numbers in the file, NaN where it states none, or is of another frame rate.

        Raises NotFoundError for a measurement that the file does not have.
        """
        label, axis = asked.arguments
        quantity = self._quantities.get(label)
        if quantity is None:
            raise NotFoundError(
                f"The file of this document has no quantity {label!r}.",
                remedy=f"It has: {', '.join(list(self._quantities)[:NAMED])}."
                if self._quantities
                else "Only C3D files of a model, such as Plug-in Gait, have quantities.",
            )
        if not quantity.has_rate(rate_of(self._head)):
            return np.full(len(ids), np.nan)
        samples = samples_at(quantity, ids)
        found: Array = np.where(samples[:, 3] < 0, np.nan, samples[:, AXES_OF_FILE.index(axis)])
        return found

    @cached_property
    def _quantities(self) -> dict[str, Quantity]:
        """By label, as the file writes it; of equal labels the first."""
        part = next((source for source in self._head.sources if source.part == "c3d"), None)
        labelled: dict[str, Quantity] = {}
        for quantity in kept_quantities(part.sections) if part is not None else ():
            labelled.setdefault(quantity.label, quantity)
        return labelled
