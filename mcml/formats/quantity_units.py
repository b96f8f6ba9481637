"""Units of quantities that a laboratory's model writes into a file: moments, forces and powers may be per kilogram."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from mcml.formats.c3d.quantities import Quantity

_PER_KILOGRAM: Final = 6000.0
"""Newton millimetres below which an ankle's moment is that of a kilogram: Plug-in Gait writes it under the unit Nmm."""

_LOADS: Final = ("MOMENTS", "FORCES", "POWERS")
_OF_MODEL: Final = ("ANGLES", *_LOADS)
_OF_WEIGHT: Final = "Normalised"
"""In labels of forces in percent of the body's weight."""


def are_per_kilogram(quantities: Iterable[Quantity]) -> bool:
    """Whether the moments of the ankles are so small that they are those of a kilogram of the body."""
    largest = 0.0
    for quantity in quantities:
        if quantity.group == "MOMENTS" and "AnkleMoment" in quantity.label and quantity.samples is not None:
            seen = quantity.samples[quantity.samples[:, 3] >= 0, :3]
            largest = max(largest, float(np.abs(seen).max(initial=0.0)))
    return 0.0 < largest < _PER_KILOGRAM


def explain_unit(quantity: Quantity, *, per_kilogram: bool) -> tuple[str, tuple[str, ...]]:
    """(unit, notes) of a quantity of a file. per_kilogram: whether its loads are (`are_per_kilogram`)."""
    if quantity.group not in _OF_MODEL:
        return quantity.unit, ()
    notes = ("as computed by the laboratory",)
    is_load = quantity.group in _LOADS and "/" not in quantity.unit and _OF_WEIGHT not in quantity.label
    if is_load and per_kilogram and quantity.unit:
        return f"{quantity.unit}/kg", (*notes, f"the file states {quantity.unit}; the values are per kg")
    return quantity.unit, notes
