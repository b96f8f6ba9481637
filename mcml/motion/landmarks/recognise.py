"""Recognise the landmark of each marker of a trial: by the set that explains most of its names, else by words.

Values computed by a model (angles, forces, axes of segments) would hide the set and are excluded first. Markers of
several people have several prefixes: each prefix is a separate body.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mcml.motion.landmarks.tables import KEY_POINTS, agreed_landmarks, key_of, marker_sets, marker_words

_SHARE, _LEAST = 0.6, 8
"""Of a body's markers that a set explains at least, and how many."""
_COMPUTED = re.compile(
    r"(?:Angles?|Forces?|Moments?|Powers?|GRF)$|^(?:CentreOfMass|CenterOfMass|Unlabell?ed|C_|\*\d)", re.I
)
_AXES = "OALP"
"""Last letters of a virtual axis: four names of one stem and all of these."""
_MIDDLE = frozenset({"c7", "t8", "t10", "t12", "jugular_notch", "xiphoid", "sacrum"})
_SIDES = {"l": "left", "r": "right", "left": "left", "right": "right"}
_PERSON_MARKERS = 5
"""Number of markers from which a prefix counts as a person's."""


@dataclass(frozen=True)
class MarkerBody:
    """The markers of one person.

    prefix: prefix of its names. set_name: the set that explains its markers, "" for none. landmarks: the landmark of
    each marker, by index. by_words: indices of markers that no set explains. markers: number of its markers.
    """

    prefix: str
    set_name: str
    landmarks: Mapping[int, str]
    by_words: frozenset[int]
    markers: int

    @property
    def are_centres(self) -> bool:
        """Whether its points are centres of joints, as those of cameras are."""
        return self.set_name in KEY_POINTS


def measured_markers(names: Sequence[str]) -> list[int]:
    """Indices of names that are no values or axes that a model computes."""
    measured = [index for index, name in enumerate(names) if name and not _COMPUTED.search(_bare(name))]
    axes = _virtual_axes([_bare(names[index]) for index in measured])
    return [index for index in measured if _bare(names[index]) not in axes]


def recognise_markers(names: Sequence[str]) -> tuple[MarkerBody, ...]:
    """Return the bodies of markers, in the order of their prefixes; none if nothing is recognised."""
    measured = measured_markers(names)
    by_prefix: dict[str, list[int]] = defaultdict(list)
    for index in measured:
        by_prefix[names[index].rpartition(":")[0].strip()].append(index)
    people = {prefix: some for prefix, some in by_prefix.items() if len(some) >= _PERSON_MARKERS}
    bodies = (_body(prefix, {index: _bare(names[index]) for index in some}) for prefix, some in people.items())
    return tuple(body for body in bodies if body.landmarks)


def _bare(name: str) -> str:
    return name.rpartition(":")[2].strip()


def _virtual_axes(names: Sequence[str]) -> set[str]:
    stems: dict[str, set[str]] = defaultdict(set)
    for name in names:
        if len(name) == len(_AXES):
            stems[name[:-1]].add(name[-1])
    return {stem + letter for stem, letters in stems.items() if set(_AXES) <= letters for letter in _AXES}


def _body(prefix: str, names: Mapping[int, str]) -> MarkerBody:
    low, high = min(names.values()), max(names.values())
    shared = low[: next((place for place, letter in enumerate(low) if high[place] != letter), len(low))]
    cut = max(shared.rfind(mark) + 1 for mark in "_-. ")
    if cut and shared[:cut].strip("_-. ").lower() not in _SIDES:
        names = {index: name[cut:] for index, name in names.items()}
    keys = {index: key_of(name) for index, name in names.items()}
    set_name = _set_of(set(keys.values()))
    claims: list[tuple[int, str, int, str]] = []
    for index, key in keys.items():
        own = marker_sets()[set_name].get(key) if set_name else None
        if own is not None:
            claims.append((0, key, index, own))
        elif set_name not in KEY_POINTS:
            told = agreed_landmarks().get(key)
            own = told or landmark_by_words(names[index])
            if own is not None:
                claims.append((1 if told else 2, key, index, own))
    # Of two markers at one landmark the surer name counts, not the place in the file: both sides agree on the marker.
    landmarks: dict[int, str] = {}
    for _, _, index, own in sorted(claims):
        if own.endswith("_tracking") or own not in landmarks.values():
            landmarks[index] = own
    by_words = {index for trust, _, index, _ in claims if trust > 0}
    return MarkerBody(prefix, set_name, landmarks, frozenset(by_words & landmarks.keys()), len(names))


def _set_of(keys: set[str]) -> str:
    """The set that explains most of some markers; on a tie the one with the larger share present."""
    best, most = "", (0, 0.0)
    for name, markers in marker_sets().items():
        explained = len(keys & markers.keys())
        claim = (explained, explained / len(markers))
        if explained >= max(_LEAST, _SHARE * len(keys)) and claim > most:
            best, most = name, claim
    return best


def landmark_by_words(name: str) -> str | None:
    """Return the landmark in a marker's own words, such as `R.Knee.Medial` or ASISr; None without one."""
    pieces = [piece.lower() for piece in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)]
    whole = "".join(pieces)
    words = marker_words()
    if words.get(whole) in _MIDDLE:
        return words[whole]
    for side, rest in _split_sides(pieces, whole, is_word=whole in words):
        landmark = words.get(rest)
        if landmark is not None and landmark not in _MIDDLE:
            return f"{_SIDES[side]}_{landmark}"
    return None


def _split_sides(pieces: Sequence[str], whole: str, *, is_word: bool) -> list[tuple[str, str]]:
    """(side, the rest without it) of a name, the clearest reading first.

    The letters of a whole word are not a side: heel.
    """
    found: list[tuple[str, str]] = []
    if len(pieces) > 1:
        for place in (0, -1):
            if pieces[place] in _SIDES:
                rest = pieces[1:] if place == 0 else pieces[:-1]
                found.append((pieces[place], "".join(rest)))
    for side in () if is_word else ("left", "right", "l", "r"):
        if whole.startswith(side):
            found.append((side, whole[len(side) :]))
        if whole.endswith(side):
            found.append((side, whole[: -len(side)]))
    return found
