"""Canonical addresses: XPaths such as `/mcml/motion/frame[100]/frame_bone[3]/@Rx` that find exactly one node.

A step has a number where the element has siblings of its tag; steps to `frame` and `frame_bone` always have one.
Written, and read, here alone; evaluating processes use it too, so it imports little.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass

MOTION = "/mcml/motion"
FRAME_TEMPLATE = "/mcml/motion/frame[%d]"
"""Of `address_frame`, for many at once."""
ALWAYS_NUMBERED = ("frame", "frame_bone")
NAMESPACE = "namespace::xml"
"""The last step to a namespace node. An element of MCML has no other."""

_FRAME = re.compile(r"/mcml/motion/frame\[(\d{1,18})\](?=/|$)")
_OF_FRAME = re.compile(
    r"/mcml/motion/frame\[(\d{1,18})\](?:/(motion_name|frame_bone)(?:\[(\d{1,9})\])?)?(?:/@([A-Za-z]+))?"
)


@dataclass(frozen=True, slots=True)
class FrameAddress:
    """The place of a node in a frame.

    frame: its position, from 1. tag: "motion_name", "frame_bone", or "" for the frame itself; number: its index among
    them. attribute: its name, None for an element.
    """

    frame: int
    tag: str
    number: int
    attribute: str | None


def address_frame(frame: int) -> str:
    """The address of the frame at a position, from 1."""
    return f"/mcml/motion/frame[{frame}]"


def address_child(frame: int, tag: str, number: int) -> str:
    """The address of the number-th `motion_name` or `frame_bone` of a frame, both from 1."""
    return f"/mcml/motion/frame[{frame}]/{tag}[{number}]"


def address_attribute(element: str, name: str) -> str:
    """The address of an attribute of the element at an address."""
    return f"{element}/@{name}"


def address_text(element: str) -> str:
    """The address of the text of the element at an address."""
    return f"{element}/text()"


def address_namespace(element: str) -> str:
    """The address of the namespace node of the element at an address."""
    return f"{element}/{NAMESPACE}"


def number_steps(tags: Sequence[str], always: Collection[str] = ()) -> list[str]:
    """The steps to siblings of these tags, in their order. always: tags that have a number even for a single sibling.

    >>> number_steps(["name", "bone", "bone"])
    ['name', 'bone[1]', 'bone[2]']
    """
    if len(tags) < 2 and not always:
        return list(tags)
    total, seen = Counter(tags), Counter[str]()
    steps = []
    for tag in tags:
        seen[tag] += 1
        steps.append(f"{tag}[{seen[tag]}]" if total[tag] > 1 or tag in always else tag)
    return steps


def split_attribute(address: str) -> tuple[str, str | None]:
    """The element's address and the attribute's name; None where the address is an element's."""
    element, slash, name = address.rpartition("/@")
    return (element, name) if slash else (address, None)


def read_frame_address(address: str) -> FrameAddress | None:
    """Parse the address of a frame, its elements or their attributes; return None for another address."""
    match = _OF_FRAME.fullmatch(address)
    return None if match is None else FrameAddress(int(match[1]), match[2] or "", int(match[3] or 1), match[4])


def find_frame(address: str) -> int | None:
    """Return the position of a node's frame, None outside the motion's frames."""
    match = _FRAME.match(address)
    return None if match is None else int(match[1])


def move_frame(address: str, frame: int) -> str:
    """The address of the same node in the frame at another position."""
    return _FRAME.sub(lambda _: address_frame(frame), address, count=1)
