"""Feet and hands of the figure. Toes and fingers move where the rig has them; else they follow foot and hand."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcml.motion.characters.measures import SIDES, Person
from mcml.motion.characters.surfaces import Drive, Line, Rings, Surface, axes_along, make_surface
from mcml.motion.rotations import rotate, shortest_arc
from mcml.motion.skeleton import Array

_FOOT = (
    (-0.033, 0.0, 0.000, 0.30), (-0.030, 0.0, 0.011, 0.42), (-0.018, 0.0, 0.0185, 0.72), (0.000, 0.0, 0.0205, 0.95),
    (0.000, 0.35, 0.0215, 0.86), (0.000, 0.70, 0.0245, 0.62), (0.000, 1.0, 0.0265, 0.44), (0.000, 1.4, 0.0255, 0.36),
    (0.000, 1.8, 0.0185, 0.28), (0.000, 1.95, 0.0095, 0.22), (0.000, 2.0, 0.000, 0.16),
)  # fmt: skip
"""Rings of a foot: how far from the ankle, in body heights, then in the distance from the ankle to the ball of the foot
(up to 1) and from there to the tip of the toes (up to 2); half the breadth in body heights; the height of the instep,
in that of the ankle."""
_ANKLE = 0.040, 0.072
"""Limits of the height of an ankle above the sole, in body heights."""
_BALL, _TOES = (0.060, 0.125), (0.030, 0.055)
"""Limits of the distances from the ankle to the ball of the foot and from there to the tip, in body heights."""
_USUAL_BALL, _USUAL_TOES = 0.085, 0.036
_SOLE = 0.012
"""How far the sole is below the joint of the toes, in body heights."""
_FLAT, _USUAL_FALL = (-0.05, 0.92), 0.40
"""Limits of the sine of the fall from the ankle to the ball in a foot that stands flat, and a usual one."""
_STANDING = 0.03
"""How much higher than the other one an ankle of a standing foot is at most, in body heights."""
_SHORT_FOOT = 0.02
"""Distance from the ankle to the ball, in body heights, below which it has no direction."""
_HAND = 0.085, 0.115
"""Limits of the length of a hand, in body heights."""
_PALM = (
    (-0.10, 0.00, 0.00), (-0.06, 0.55, 0.60), (0.02, 0.68, 0.80), (0.18, 0.90, 1.00), (0.36, 1.00, 0.95),
    (0.50, 0.98, 0.82), (0.57, 0.72, 0.60), (0.59, 0.00, 0.00),
)  # fmt: skip
"""Rings of a palm: part of the hand's length from the wrist, half-axes of the palm's."""
_PALM_WIDTH, _PALM_DEPTH = 0.0240, 0.0115
_FINGERS = ((0.0170, 0.86), (0.0058, 1.00), (-0.0058, 0.95), (-0.0165, 0.78))
"""Fingers without joints: how far beside the middle of the hand, in body heights, and their tip, in its length."""
_FINGER, _THUMB = 0.0056, 0.0070
"""Half of how thick, in body heights."""
_FEW = 3
"""Chains of joints from which a hand has fingers that move."""


def make_foot(person: Person, side: str) -> Surface:
    """A foot with a flat sole."""
    ankle, height = person.place(f"{side}_foot"), person.height
    ahead, up, fall, ball, toes = _foot_axes(person, side)
    across = np.cross(up, ahead)
    sole = float(np.clip(fall + _SOLE * height, _ANKLE[0] * height, _ANKLE[1] * height))
    table = np.array(_FOOT)
    along = table[:, 0] * height + np.minimum(table[:, 1], 1) * ball + np.maximum(table[:, 1] - 1, 0) * toes
    tall = table[:, 3] * sole
    rings = Rings(
        ankle + along[:, None] * ahead + (tall / 2 - sole)[:, None] * up,
        np.broadcast_to(across, (len(table), 3)),
        np.broadcast_to(up, (len(table), 3)),
        table[:, 2] * height,
        np.where(table[:, 2] > 0, tall / 2, 0.0),
        along,
    )
    # Rings are counterclockwise seen from the tip: across, then up.
    joint = person.at[f"{side}_foot"]
    tip = person.at.get(f"{side}_toes", -1)
    if joint not in person.above(tip):
        return make_surface(rings, Drive((joint,), np.array([-np.inf]), np.ones(1)), 12)
    line = person.path(joint, tip)
    starts = np.concatenate([[-np.inf], np.maximum.accumulate((person.places[line[1:]] - ankle) @ ahead)])
    return make_surface(rings, Drive(tuple(line), starts, np.full(len(line), 0.5 * toes)), 12)


def _foot_axes(person: Person, side: str) -> tuple[Array, Array, float, float, float]:
    """Where a foot points and its upper side (3,), the fall from ankle to ball, and the lengths to ball and tip.

    The sole is across the plane of the shank, not level: legs may be apart in the reference pose, or in a step.
    """
    height, ankle = person.height, person.place(f"{side}_foot")
    along = ankle - person.place(f"{side}_low_leg")
    shank = rotate(shortest_arc(-person.up, along), np.stack([person.left, person.on]))
    ball, ends = _ball(person, side)
    vector = ball - ankle
    size = float(np.linalg.norm(vector))
    if size < _SHORT_FOOT * height:
        return shank[1], np.cross(shank[1], shank[0]), 0.0, _USUAL_BALL * height, _USUAL_TOES * height
    toward = vector / size
    across = shank[0] - (shank[0] @ toward) * toward
    if np.linalg.norm(across) < 0.1:
        # Toes to the side: the foot turns about the shank.
        across = np.cross(-along, toward)
    rise = np.cross(toward, across / np.linalg.norm(across))
    sine = _usual_fall(person)
    cosine = float(np.sqrt(1 - sine**2))
    ahead, up = cosine * toward + sine * rise, cosine * rise - sine * toward
    far = cosine * size
    limits = np.array([_BALL, _TOES]) * height
    reach = max((float((end - ankle) @ ahead) for end in ends), default=0.0) - far
    toes = reach if f"{side}_toes" in person.at and reach > 0 else _USUAL_TOES * height
    return ahead, up, sine * size, float(np.clip(far, *limits[0])), float(np.clip(toes, *limits[1]))


def _ball(person: Person, side: str) -> tuple[Array, list[Array]]:
    """The place (3,) of the ball of a foot, that of the ankle where it is not known, and of the ends of the foot."""
    joint, tip = person.at[f"{side}_foot"], person.at.get(f"{side}_toes", -1)
    ankle = person.places[joint]
    ends = [place for owner, place in person.tips if owner in (joint, tip, *person.below(joint))]
    if tip >= 0:
        return person.places[tip], ends
    farthest = max(ends, key=lambda end: float(np.linalg.norm(end - ankle)), default=ankle)
    return ankle + 0.7 * (farthest - ankle), ends


def _usual_fall(person: Person) -> float:
    """Sine of the angle by which the line from the ankle to the ball falls in a foot that stands flat.

    It is that of the feet that the body stands on in the reference pose, the lower ones; both feet have the same.
    """
    ankles = {side: float(person.place(f"{side}_foot") @ person.up) for side in SIDES}
    falls = []
    for side, level in ankles.items():
        vector = _ball(person, side)[0] - person.place(f"{side}_foot")
        size = float(np.linalg.norm(vector))
        if level < min(ankles.values()) + _STANDING * person.height and size > _SHORT_FOOT * person.height:
            falls.append(float(-(vector @ person.up)) / size)
    flat = [fall for fall in falls if _FLAT[0] <= fall <= _FLAT[1]]
    return sum(flat) / len(flat) if flat else _USUAL_FALL


def make_hand(person: Person, side: str) -> Iterator[Surface]:
    """A palm, four fingers and a thumb."""
    wrist = person.hand(side)
    place, height = person.places[wrist], person.height
    chains = _chains(person, wrist)
    heading, across, length = _hand_axes(person, side, chains)
    across, palm = axes_along(heading[None], heading, across)
    across, palm = across[0], palm[0]
    middle = _middle_line(person, side, wrist, chains)
    starts = np.maximum.accumulate((person.places[middle] - place) @ heading)
    below = person.parents[wrist]
    drive = Drive((below, *middle), np.array([-np.inf, *starts]), np.full(len(middle) + 1, 0.12 * length))
    yield _palm(person, place, heading, across, palm, length, drive)
    if len(chains) >= _FEW:
        for chain in chains[:5]:
            yield _finger(person, chain, across)
        return
    for beside, reach in _FINGERS:
        start = place + 0.45 * length * heading + beside * height * across
        end = place + reach * length * heading + 1.1 * beside * height * across
        yield _rod(person, np.stack([start, end]), drive, across, _FINGER, along=(start - place) @ heading)
    start = place + 0.14 * length * heading + 0.6 * _PALM_WIDTH * height * across
    end = start + length * (0.34 * heading + 0.20 * across)
    yield _rod(person, np.stack([start, end]), drive, across, _THUMB, along=(start - place) @ heading)


def _chains(person: Person, wrist: int) -> list[list[int]]:
    """The fingers of a hand: chains of at least two bones in a row that have a length, the longest first."""
    below = person.below(wrist)
    leaves = [joint for joint in below if not person.children(joint)]
    lines = [person.path(wrist, leaf)[1:] for leaf in leaves]
    # What several chains share is the palm.
    shared = {joint for joint in below if sum(joint in line for line in lines) > 1}
    fingers = [[joint for joint in line if joint not in shared] for line in lines]
    return [line for line in fingers if len(line) + any(owner == line[-1] for owner, _ in person.tips) >= 3]


def _hand_axes(person: Person, side: str, chains: list[list[int]]) -> tuple[Array, Array, float]:
    """Where a hand points, the way from its little finger to its thumb (3,), and its length."""
    wrist, height = person.hand(side), person.height
    place = person.places[wrist]
    ends = [person.places[joint] for joint in person.below(wrist)]
    ends += [tip for owner, tip in person.tips if wrist in person.above(owner)]
    farthest = max(ends, key=lambda end: float(np.linalg.norm(end - place)), default=place)
    reach = float(np.linalg.norm(farthest - place))
    fore = place - person.place(f"{side}_low_arm")
    fore /= np.linalg.norm(fore)
    heading = fore
    if reach > 0.03 * height and (farthest - place) @ fore > 0.3 * reach:
        heading = (farthest - place) / reach
    length = float(np.clip(reach or 1e9, _HAND[0] * height, _HAND[1] * height)) if reach else 0.105 * height
    outwards = person.left if side == "left" else -person.left
    across = rotate(shortest_arc(outwards, heading), person.on)
    second, fifth = (person.at.get(f"{side}_finger_{name}", -1) for name in ("two", "five"))
    if len(chains) >= _FEW and min(second, fifth) >= 0:
        beside = person.places[second] - person.places[fifth]
        beside = beside - (beside @ heading) * heading
        if np.linalg.norm(beside) > 0.005 * height:
            across = beside / np.linalg.norm(beside)
    return heading, across, length


def _middle_line(person: Person, side: str, wrist: int, chains: list[list[int]]) -> list[int]:
    """Return the joints of the palm, from the wrist on, and those of fingers that all fingers share."""
    if len(chains) >= _FEW:
        return [wrist]
    for name in (f"{side}_fingers", f"{side}_hand"):
        if name in person.at and person.path(wrist, person.at[name]):
            return person.path(wrist, person.at[name])
    return [wrist]


def _palm(
    person: Person, place: Array, heading: Array, across: Array, palm: Array, length: float, drive: Drive
) -> Surface:
    table = np.array(_PALM)
    along = table[:, 0] * length
    rings = Rings(
        place + along[:, None] * heading,
        np.broadcast_to(across, (len(table), 3)),
        np.broadcast_to(palm, (len(table), 3)),
        _PALM_WIDTH * person.height * table[:, 1],
        _PALM_DEPTH * person.height * table[:, 2],
        along,
    )
    return make_surface(rings, drive, 10)


def _finger(person: Person, chain: list[int], across: Array) -> Surface:
    """A finger along its joints, to its tip."""
    places = [person.places[joint] for joint in chain]
    tip = next((place for owner, place in person.tips if owner == chain[-1]), None)
    if tip is not None:
        places.append(tip)
    line = Line(np.stack(places))
    lengths = line.lengths
    joints = chain if tip is not None else chain[:-1]
    starts = lengths[: len(joints)]
    thick = _FINGER * person.height
    drive = Drive((person.parents[chain[0]], *joints), np.array([-np.inf, *starts]), np.full(len(joints) + 1, thick))
    return _rod(person, line.places, drive, across, _FINGER)


def _rod(person: Person, places: Array, drive: Drive, across: Array, thick: float, along: float = 0.0) -> Surface:
    """A round rod with round ends along a line. along: where on the line of its joints it begins."""
    line = Line(places)
    radius, lengths = thick * person.height, line.lengths
    inner = np.unique(np.round(np.concatenate([lengths[1:-1], lengths[-1] * np.array([0.0, 0.5, 0.85])]), 12))
    reach = lengths[-1]
    where = np.concatenate([[-0.9 * radius], [-0.5 * radius], inner, [reach - 0.3 * radius, reach]])
    where = np.maximum.accumulate(where)
    halves = np.concatenate([[0.0], [0.75], np.linspace(1.1, 0.9, len(inner)), [0.6, 0.0]]) * radius
    headings = line.headings(where, radius)
    level = across - (headings[0] @ across) * headings[0]
    if np.linalg.norm(level) < 0.1:
        level = np.cross(headings[0], np.eye(3)[int(np.argmin(np.abs(headings[0])))])
    first, second = axes_along(headings, headings[0], level / np.linalg.norm(level))
    return make_surface(Rings(line.at(where), first, second, halves, halves, along + where), drive, 6)
