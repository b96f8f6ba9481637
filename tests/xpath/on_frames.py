"""Conditions on frames: on their ids, and on all of their frame_bones together."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

CHANNELS = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")
OPERATORS = ("<", "<=", ">", ">=", "=", "!=")


def of_id(random: Random, frame: Any, quoted: Callable[[str], str]) -> str:
    """About the id, one that some frame of the document has or one near it."""
    own = random.choice(frame.getparent().findall("frame")).get("id")
    near = own if own.isdigit() and random.random() < 0.7 else str(random.choice([-2, 0, 1, 4, 5, 6, 8]))
    return random.choice([
        f"@id={quoted(own)}", f"@id={near}", f"{near} = @id", f"@id={quoted(near)}",
        f"@id >= {near}", f"@id != {near}", f"not(@id={near})", "@id=../frame[last()]/@id",
    ])  # fmt: skip


def of_frame_bones(random: Random, frame: Any) -> str:
    """Whether any or every frame_bone is so, how many are, what their samples add up to, how they change. XPath 1.0."""
    pick = random.choice
    one, other = _bone_condition(random, frame), _bone_condition(random, frame)
    channel = pick(CHANNELS)
    held = [float(bone.get(channel)) for bone in frame.findall("frame_bone") if channel in bone.attrib]
    count, bound = random.randint(0, len(frame) + 1), _near(random, sum(held))
    some, name = pick(["", f"[{one}]"]), pick([bone.get("name") for bone in frame.findall("frame_bone")] or ["none"])
    moved = f"frame_bone[@name='{name}']/@{channel}"
    return pick([
        f"frame_bone[{one}]", f"not(frame_bone[{one}])", f"not(frame_bone[not({one})])",
        f"not(frame_bone[{one}]) or frame_bone[{other}]", f"boolean(frame_bone[not({one}) and {other}])",
        f"count(frame_bone[{one}]) {pick(OPERATORS)} {count}", f"{count} {pick(OPERATORS)} count(frame_bone[{one}])",
        f"count(frame_bone[{one}]/@{channel}) {pick(OPERATORS)} count(frame_bone[{other}])",
        f"count(frame_bone[{one}][not({other})]) {pick(OPERATORS)} {count} - 1",
        f"sum(frame_bone{some}/@{channel}) {pick(OPERATORS)} {bound}",
        f"frame_bone/@{channel} {pick(OPERATORS)} {bound}",
        f"{bound} {pick(OPERATORS)} sum(frame_bone{some}/@{channel}) div count(frame_bone/@{channel})",
        f"{moved} {pick(OPERATORS)} {pick(['following', 'preceding'])}-sibling::frame[{pick('112')}]/{moved}",
        f"sum(frame_bone/@{channel}) {pick(OPERATORS)} sum(preceding-sibling::frame[1]/frame_bone/@{channel})",
        f"@*[. {pick(OPERATORS)} {bound}] or frame_bone/@*[. {pick(OPERATORS)} {bound}]",
    ])  # fmt: skip


def of_any_attribute(random: Random, tree: Any) -> str:
    """About attributes of any name: some value that one of them has, or a number near it."""
    value = str(random.choice(tree.xpath("//@*")))
    texts = [value, value, "0.0", "-0.0", "x", "1.50", "nan"]
    if random.random() < 0.4:
        text = random.choice(texts)
        return f"//@*[{random.choice(['. = {}', '{} = .']).format(repr(text))}]"
    number = float(value) if value.replace(".", "", 1).lstrip("-").isdigit() else random.choice([0.0, 10.5, 3.0, -4.0])
    sides = [".", _near(random, number)]
    random.shuffle(sides)
    return random.choice(["{}", "count({})", "{}/..", "boolean({})"]).format(
        f"//@*[{sides[0]} {random.choice(OPERATORS)} {sides[1]}]"
    )


def later_of_frame_bones(random: Random, frame: Any) -> list[str]:
    """The same, as XPath 2.0 says it."""
    pick = random.choice
    one, channel = _bone_condition(random, frame), pick(CHANNELS)
    held = [float(bone.get(channel)) for bone in frame.findall("frame_bone") if channel in bone.attrib] or [1.0]
    bounds = {name: _near(random, of(held)) for name, of in (("max", max), ("min", min), ("avg", _mean))}
    some = pick(["", "", f"[{one}]", f"[not({one})]"])
    compared = [f"{name}(frame_bone{some}/@{channel}) {pick(OPERATORS)} {bound}" for name, bound in bounds.items()]
    turned = [f"{bound} {pick(OPERATORS)} {name}(frame_bone{some}/@{channel})" for name, bound in bounds.items()]
    return [
        *compared, *turned, f"exists(frame_bone[{one}])", f"empty(frame_bone[{one}])",
        f"every $b in frame_bone satisfies $b/@{channel} {pick(OPERATORS)} {bounds['min']}",
        f"some $b in frame_bone satisfies not($b/@{channel} {pick(OPERATORS)} {bounds['max']})",
    ]  # fmt: skip


def _bone_condition(random: Random, frame: Any) -> str:
    """A comparison of a channel with a number near one that a frame_bone has."""
    channel, other = random.choice(CHANNELS), random.choice(CHANNELS)
    held = [float(bone.get(channel)) for bone in frame.findall("frame_bone") if channel in bone.attrib] or [0.0]
    operator = random.choice(OPERATORS)
    if random.random() < 0.2:
        return f"@{channel} {operator} @{other}"
    return f"@{channel} {operator} {_near(random, random.choice(held))}"


def _near(random: Random, value: float) -> str:
    near = value + random.choice([-2, -0.5, 0, 0, 0.25, 3])
    return repr(near) if random.random() < 0.3 and "e" not in repr(near) else f"{near:.{random.choice([0, 1, 6])}f}"


def _mean(numbers: list[float]) -> float:
    return sum(numbers) / len(numbers)
