"""The HIERARCHY of a BVH file in the usual form of programs, read several times faster than by `hierarchy`.

One pattern takes a whole joint up to its first child. Everything else (joints with blanks in their names, braces on the
same line, mistakes) is left to the reader of the whole grammar, which reports errors.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from mcml.errors import FormatError, LimitError, Place
from mcml.formats.format import Limits
from mcml.motion.skeleton import EndSite, Triple

CHANNEL_OF = {
    f"{axis.lower()}{kind}": f"{letter}{axis.lower()}"
    for kind, letter in (("position", "T"), ("rotation", "R"))
    for axis in "XYZ"
}
"""The channel of each word of BVH, in small letters."""

_NUMBER = r"([+-]?(?:[0-9]{1,17}(?:\.[0-9]{0,100})?|\.[0-9]{1,100}))"
_OFFSET = rf"\{{\s*OFFSET[ \t]+{_NUMBER}[ \t]+{_NUMBER}[ \t]+{_NUMBER}[ \t]*[\r\n]\s*"
_STEP = re.compile(
    rf"(ROOT|JOINT)[ \t]+([^\s{{}}]+)[ \t]*[\r\n]\s*{_OFFSET}"
    r"(?:CHANNELS[ \t]+([0-9]{1,2})((?:[ \t]+[XYZ](?:position|rotation))+)[ \t]*[\r\n]\s*)?"
    rf"|End[ \t]+Site[ \t]*[\r\n]\s*{_OFFSET}\}}\s*"
    r"|\}\s*",
    re.ASCII,
)
_BEGINNING = re.compile(r"\s*HIERARCHY[ \t]*[\r\n]\s*", re.ASCII)


@dataclass
class OpenJoint:
    """A joint whose body is being read."""

    name: str
    parent: int
    at: Place
    offset: Triple | None = None
    channels: tuple[str, ...] | None = None
    children: int = 0
    end_sites: list[EndSite] = field(default_factory=list)


def read_plain(text: str, limits: Limits) -> list[OpenJoint] | None:
    """The joints of a text that is a hierarchy, HIERARCHY to the last brace. None where it is not a plain one."""
    beginning = _BEGINNING.match(text)
    if beginning is None:
        return None
    joints: list[OpenJoint] = []
    stack: list[int] = []
    end = beginning.end()
    while (step := _STEP.match(text, end)) is not None:
        end = step.end()
        keyword, name, x, y, z, count, words, *site = step.groups()
        if keyword is None:
            if not stack:
                return None
            if site[0] is None:
                stack.pop()
            else:
                joint = joints[stack[-1]]
                joint.end_sites.append(EndSite((site[0], site[1], site[2]), "", joint.children))
            continue
        channels = None if count is None else tuple(CHANNEL_OF[word] for word in words.lower().split())
        if channels is not None and not len(channels) == len(set(channels)) == int(count):
            return None
        if (keyword == "ROOT") == bool(stack) or len(stack) >= limits.depth or not _fits(name, limits):
            return None
        joints.append(OpenJoint(name, stack[-1] if stack else -1, Place(), (x, y, z), channels))
        if stack:
            joints[stack[-1]].children += 1
        stack.append(len(joints) - 1)
    is_whole = end == len(text) and joints and not stack and len(joints) <= limits.joints
    return joints if is_whole else None


def _fits(name: str, limits: Limits) -> bool:
    try:
        limits.check_name(name)
    except (FormatError, LimitError):
        return False
    return True
