"""Trials of a laboratory written anew by ezc3d: the same walk in other units, axes, orders, labels and plates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import ezc3d
import numpy as np

from mcml.motion.skeleton import Array

Trial = Any
"""What ezc3d reads: a dictionary of header, parameters and data."""
_TYPED: Final = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")
UPRIGHT: Final = np.eye(3)


class NotRewritableError(Exception):
    """The trial has nothing that could be written otherwise."""


def texts(trial: Trial, group: str, name: str) -> list[str] | None:
    value = trial["parameters"].get(group, {}).get(name, {}).get("value")
    return None if value is None else [text.strip() for text in ([value] if isinstance(value, str) else value)]


def markers_of(trial: Trial) -> list[int]:
    quantities = {label for group in _TYPED for label in texts(trial, "POINT", group) or ()}
    return [index for index, label in enumerate(texts(trial, "POINT", "LABELS") or ()) if label not in quantities]


def place(turn: Array, way: Sequence[float] = (0.0, 0.0, 0.0)) -> Callable[[Trial], None]:
    """Turn and move all markers and plates. way: millimetres."""

    def rewrite(trial: Trial) -> None:
        points, markers = trial["data"]["points"], markers_of(trial)
        points[:3, markers] = np.einsum("ij,jnf->inf", turn, points[:3, markers]) + np.array(way)[:, None, None]
        plates = trial["parameters"]["FORCE_PLATFORM"]
        if np.size(plates["CORNERS"]["value"]):
            moved = np.einsum("ij,jkp->ikp", turn, plates["CORNERS"]["value"]) + np.array(way)[:, None, None]
            plates["CORNERS"]["value"] = moved

    return rewrite


def on_screen(turn: Array, right: str, up: str) -> Callable[[Trial], None]:
    def rewrite(trial: Trial) -> None:
        place(turn)(trial)
        trial.add_parameter("POINT", "X_SCREEN", [right])
        trial.add_parameter("POINT", "Y_SCREEN", [up])

    return rewrite


def in_unit(unit: str, factor: float) -> Callable[[Trial], None]:
    """factor: of the unit in a millimetre."""

    def rewrite(trial: Trial) -> None:
        if "Nmm" not in (texts(trial, "ANALOG", "UNITS") or ()):
            raise NotRewritableError("moments of plates have the unit of the points")
        trial["data"]["points"][:3, markers_of(trial)] *= factor
        trial.add_parameter("POINT", "UNITS", [unit, *(texts(trial, "POINT", "UNITS") or [])[1:]])
        plates = trial["parameters"]["FORCE_PLATFORM"]
        for name in ("CORNERS", "ORIGIN"):
            plates[name]["value"] = np.asarray(plates[name]["value"]) * factor

    return rewrite


def with_prefix(trial: Trial) -> None:
    for name in ("LABELS", *_TYPED):
        labels = texts(trial, "POINT", name)
        if labels is not None:
            trial.add_parameter("POINT", name, [f"Kim:{label}" for label in labels])


def shuffle_points(trial: Trial) -> None:
    count = trial["data"]["points"].shape[1]
    order = np.random.default_rng(1).permutation(count)
    trial["data"]["points"] = trial["data"]["points"][:, order]
    for name, values in trial["data"]["meta_points"].items():
        trial["data"]["meta_points"][name] = values[:, order]
    for name in ("LABELS", "DESCRIPTIONS"):
        written = texts(trial, "POINT", name)
        if written is not None and len(written) == count:
            trial.add_parameter("POINT", name, [written[index] for index in order])


def shuffle_channels(trial: Trial) -> None:
    count = trial["data"]["analogs"].shape[1]
    order = np.random.default_rng(2).permutation(count)
    trial["data"]["analogs"] = trial["data"]["analogs"][:, order]
    for name, parameter in trial["parameters"]["ANALOG"].items():
        value = parameter.get("value") if isinstance(parameter, dict) else None
        if name != "USED" and value is not None and len(value) == count:
            parameter["value"] = [value[index] for index in order] if isinstance(value, list) else value[order]
    channels = trial["parameters"]["FORCE_PLATFORM"]["CHANNEL"]
    channels["value"] = np.argsort(order)[np.asarray(channels["value"], int) - 1] + 1


def reverse_plates(trial: Trial) -> None:
    for name in ("CORNERS", "ORIGIN", "CHANNEL", "TYPE", "CAL_MATRIX"):
        parameter = trial["parameters"]["FORCE_PLATFORM"].get(name)
        if parameter is not None:
            parameter["value"] = np.asarray(parameter["value"])[..., ::-1]


def write_action(trial: Trial) -> None:
    """Plates state the force on the ground instead of the force on the body."""
    channels = np.asarray(trial["parameters"]["FORCE_PLATFORM"]["CHANNEL"]["value"], int)
    trial["data"]["analogs"][:, np.unique(channels) - 1] *= -1


def calibrate(trial: Trial) -> None:
    """Plates of type 2 become plates of type 4, whose matrix changes nothing."""
    types = np.ravel(trial["parameters"]["FORCE_PLATFORM"]["TYPE"]["value"])
    if set(types.tolist()) != {2}:
        raise NotRewritableError("the plates are not of type 2")
    trial["parameters"]["FORCE_PLATFORM"]["TYPE"]["value"] = np.full(len(types), 4)
    trial.add_parameter("FORCE_PLATFORM", "CAL_MATRIX", np.repeat(np.eye(6)[:, :, None], len(types), axis=2))


def about_z(degrees: float) -> Array:
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


REWRITES: Final[dict[str, Callable[[Trial], None]]] = {
    "metres": in_unit("m", 0.001),
    "inches": in_unit("in", 1 / 25.4),
    "walks the other way": place(about_z(180.0)),
    "walks askew": place(about_z(37.0)),
    "another origin": place(UPRIGHT, (5000.0, -3000.0, 400.0)),
    "Y up": on_screen(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]), "+X", "+Y"),
    "X up": on_screen(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), "+Y", "+X"),
    "prefix": with_prefix,
    "points in another order": shuffle_points,
    "channels in another order": shuffle_channels,
    "plates in another order": reverse_plates,
    "action": write_action,
    "plates of type 4": calibrate,
}


def rewrite(source: Path, name: str, target: Path) -> None:
    """Write a trial anew. Raises NotRewritableError."""
    trial = ezc3d.c3d(str(source))
    REWRITES[name](trial)
    trial.write(str(target))
