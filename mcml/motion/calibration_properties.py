"""Properties of a header that keep what people set of a calibration: "calibration floor" and so on.

Their values are JSON. The unit and the up axis are set by the header's own elements. Lengths are in the unit of the
clip, poses in its axes, so they change with these.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, TypeAlias

import numpy as np
import orjson

from mcml.motion.clip import ReferencePose
from mcml.motion.rotations import inverse, multiply, rotate
from mcml.motion.skeleton import Array

OVERRIDES: Final = "calibration "
"""Properties whose names begin so are values that people set."""

Properties: TypeAlias = tuple[tuple[str, str, str], ...]

_LENGTHS: Final = ("floor", "leg")


def read_value(name: str, text: str) -> Any:
    """The value of a property of a calibration, by its name without the beginning. Raises ValueError for text that is
    no JSON, and for a pose of another form than seven numbers a joint.
    """
    value = orjson.loads(text)
    if name != "pose":
        return value
    numbers = np.array(value if isinstance(value, list) else (), dtype=np.float64)
    if numbers.ndim != 2 or numbers.shape[1] != 7 or not np.isfinite(numbers).all():
        raise ValueError("a pose has seven numbers a joint")
    return ReferencePose.from_json(numbers.tolist())


def scale_values(properties: Properties, factor: float, *, resizes: bool) -> Properties:
    """The properties of a clip whose lengths are multiplied.

    resizes: the body changes its size; else the unit does, and so do the metres of a unit.
    """

    def change(name: str, value: Any) -> Any:
        if name == "pose":
            return ReferencePose(_tuples(np.array(value.positions) * factor), value.rotations)
        if isinstance(value, bool) or not isinstance(value, int | float):
            return value
        if name == "metres" and not resizes:
            return value / factor
        return value * factor if name in _LENGTHS else value

    return _change(properties, change)


def turn_values(properties: Properties, turn: Array, axes: Mapping[str, str]) -> Properties:
    """The properties of a clip that is turned.

    turn: (4,) unit quaternion. axes: where each axis, such as "Y" or "-Z", points then.
    """

    def change(name: str, value: Any) -> Any:
        if name == "pose":
            rotations = multiply(multiply(turn, np.array(value.rotations)), inverse(turn))
            return ReferencePose(_tuples(rotate(turn, np.array(value.positions))), _tuples(rotations))
        return axes.get(value, value) if name == "up" and isinstance(value, str) else value

    return _change(properties, change)


def _change(properties: Properties, change: Callable[[str, Any], Any]) -> Properties:
    return tuple(_change_one(item, change) for item in properties)


def _change_one(item: tuple[str, str, str], change: Callable[[str, Any], Any]) -> tuple[str, str, str]:
    """Change the value of a property of a calibration; leave other properties, and values that cannot be read."""
    if not item[0].startswith(OVERRIDES):
        return item
    name = item[0].removeprefix(OVERRIDES)
    try:
        value = read_value(name, item[1])
    except ValueError:
        return item
    changed = change(name, value)
    if changed is value:
        return item
    told = changed.to_json() if isinstance(changed, ReferencePose) else changed
    return item[0], orjson.dumps(told).decode(), item[2]


def _tuples(rows: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, rows.tolist()))
