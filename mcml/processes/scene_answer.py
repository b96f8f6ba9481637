"""The answer of a program that evaluates a scene: a line of JSON, then numbers.

The line has `rigs` (names, parents, rest of each joint as 12 numbers, bound likewise or null, shapes, face, tips),
`takes` (name, rig, frames, rate, notices), unit, up and notices, or `error`, `remedy` and `kind` instead. The numbers
are float64 in the order of the machine: of each frame of each take the transform (3, 4) of each joint to the world, row
by row, then the weight of each blend shape. Needs no NumPy, whose import takes longer than to read a short file.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, BinaryIO

SECONDS = 60.0
MEMORY = 2 << 30
"""Bytes of the process that reads."""
SEND = "Send a file with a skeleton and its animation."


@dataclass(frozen=True)
class WrittenRig:
    """rest: of each joint 12 numbers. bound: likewise where a skin was bound to it, else None. shapes: names of blend
    shapes. face: whether it has no bones, and the joints are the nodes that have these blend shapes. tips: JSON
    of the tips of bones that this program wrote, (joint, tip) each, in the order of the file."""

    names: Sequence[str]
    parents: Sequence[int]
    rest: Sequence[Sequence[float]]
    bound: Sequence[Sequence[float] | None]
    shapes: Sequence[str] = ()
    face: bool = False
    tips: str = ""


@dataclass(frozen=True)
class WrittenTake:
    """rig: its place among the rigs."""

    name: str
    rig: int
    frames: int
    rate: float
    notices: Sequence[str] = ()


class UnreadableError(Exception):
    """The file cannot be read. kind: "format" or "limit"; remedy: how to mend it."""

    def __init__(self, what: str, remedy: str = "", kind: str = "format") -> None:
        super().__init__(what)
        self.facts = {"error": what, "remedy": remedy, "kind": kind}


def write_scene(
    target: BinaryIO,
    rigs: Sequence[WrittenRig],
    takes: Sequence[WrittenTake],
    poses: Iterable[bytes],
    *,
    unit: str,
    up: str,
    notices: Sequence[str] = (),
) -> None:
    """Write a scene. poses: the numbers of each frame of each take, in order."""
    head = {
        "rigs": [asdict(rig) for rig in rigs],
        "takes": [asdict(take) for take in takes],
        "unit": unit,
        "up": up,
        "notices": list(notices),
    }
    target.write(json.dumps(head).encode() + b"\n")
    for pose in poses:
        target.write(pose)


def run_program(make: Callable[[Mapping[str, Any], BinaryIO, BinaryIO], None]) -> None:
    """Bound this process, and let `make` read the standard input and write the answer, or say why it cannot.

    make: takes the options, the file, and the target of the answer.
    """
    if sys.platform != "win32":
        from mcml.processes.bounds import end_after

        end_after(SECONDS)
    target = sys.stdout.buffer
    try:
        make(json.loads(sys.argv[1]), sys.stdin.buffer, target)
    except UnreadableError as error:
        target.write(json.dumps(error.facts).encode() + b"\n")
    target.flush()


def check_motion(limits: Mapping[str, Any], frames: int, joints: int, shapes: int = 0) -> None:
    """Raises UnreadableError where a motion is larger than the limits allow."""
    if joints + shapes > limits["joints"]:
        raise UnreadableError(
            f"the skeleton has {joints + shapes} joints and blend shapes, the limit is {limits['joints']}",
            "Remove joints.",
            "limit",
        )
    if frames > limits["frames"] or frames * (joints * 6 + shapes) > limits["values"]:
        raise UnreadableError(
            f"the motion has {frames} frames of {joints} joints, which is more than the limits allow",
            "Cut it into parts, or ask for a lower `rate`.",
            "limit",
        )


def check_takes(takes: int, joints: int, limit: int) -> None:
    """Raises UnreadableError where there is no take, or more than the limit."""
    if not takes:
        raise UnreadableError(f"the file has a skeleton of {joints} joints and no motion", SEND)
    if takes > limit:
        raise UnreadableError(
            f"the file holds {takes} takes, the limit is {limit}", "Save them in several files.", "limit"
        )
