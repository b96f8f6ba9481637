"""Virtual markers: those of a standing trial that walking trials lack, carried by other markers of their segment.

Laboratories take markers off the inner sides of knees and ankles, or all of both joints, before a person walks. A rigid
fit of the segment's remaining markers to their places in standing tells where they would be. Sources: Cappozzo, Catani,
Della Croce and Leardini 1995 ("Position and orientation in space of bones during movement", the technique known as
CAST); Söderkvist and Wedin 1993 ("Determining the movements of the skeleton using well-configured markers").
Lengths are millimetres.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.laboratory.gait_model.lower_body import Markers
from mcml.motion.skeleton import Array

LEAST: Final = 3
"""Markers that tell where a segment is."""

LOST: Final = 20.0
"""Millimetres (rms) from their places in standing from which markers carry nothing: labels were exchanged."""

VIRTUAL: Final[Mapping[str, str]] = {
    "KneeLateral": "thigh", "KneeMedial": "thigh", "AnkleLateral": "shank", "AnkleMedial": "shank",
}  # fmt: skip
"""Segment of each virtual marker, without the side."""

_LATERAL: Final = {"thigh": "KneeLateral", "shank": "AnkleLateral"}
_ENDS: Final = {"thigh": ("ASI", "KneeLateral"), "shank": ("KneeLateral", "AnkleLateral")}
_SHARES: Final = {"thigh": (0.3, 0.97), "shank": (0.03, 0.97)}
"""Of the line between the ends of a segment, where its markers are beside it."""
_BESIDE: Final = 150.0
_NARROW: Final = 10.0
"""Spread across the line of best fit below which markers are on one line, and tell no turn about it."""


@dataclass(frozen=True)
class VirtualMarker:
    """places: (x, y, z) of each other marker of the segment in standing, from the virtual one, by its name."""

    places: Mapping[str, tuple[float, ...]]

    def known_by(self, names: Collection[str]) -> VirtualMarker | None:
        """The same by those of these markers that tell it, None for too few."""
        places = {name: place for name, place in self.places.items() if name in names}
        return VirtualMarker(places) if _is_wide(np.array([*places.values()]).reshape(-1, 3)) else None

    def locate(self, markers: Markers) -> tuple[Array, Array]:
        """((n, 3) the virtual marker, (n,) rms distance of the others from their places after the fit).

        markers: (n, 3) by name. The marker is NaN in frames with fewer than three of them, with all on one line, or
        with a distance above LOST.
        """
        template = np.array([*self.places.values()])
        positions = np.stack([markers[name] for name in self.places], axis=1)
        found, away = np.full((len(positions), 3), np.nan), np.full(len(positions), np.nan)
        known = np.isfinite(positions).all(axis=2)
        for pattern in np.unique(known, axis=0):
            rows = np.flatnonzero((known == pattern).all(axis=1))
            if _is_wide(template[pattern]):
                found[rows], away[rows] = _fit(template[pattern], positions[rows][:, pattern])
        found[away > LOST] = np.nan
        return found, away


def find_virtual_markers(
    markers: Markers, others: Markers, segments: Mapping[str, str], labels: Mapping[str, str]
) -> Iterator[tuple[str, VirtualMarker]]:
    """Yield (name with its side, virtual marker) of each marker of knees and ankles in a standing trial.

    markers: (n, 3) by the names of `model_markers`. others: (n, 3) all markers of the person by their labels. segments:
    "left_thigh" and such of labels that are known to follow a segment, "" of labels that nothing is known of; those are
    taken by their places beside a segment, where fewer than three are known. labels: of `markers`.
    """
    means = {name: _mean(places) for name, places in markers.items()}
    places = {label: _mean(others[label]) for label in {*segments, *labels.values()} if label in others}
    for side, word in (("L", "left"), ("R", "right")):
        for segment in ("thigh", "shank"):
            own = [label for label, known in segments.items() if known == f"{word}_{segment}"]
            if len(own) < LEAST:
                unknown = {label: places[label] for label, known in segments.items() if not known and label in places}
                own += _find_beside(side, segment, means, unknown)
            for stem in (stem for stem, of in VIRTUAL.items() if of == segment and side + stem in means):
                lateral = labels.get(side + _LATERAL[segment])
                # It is on the bone itself, and far from the others: it holds the fit at the joint.
                add = [lateral] if lateral and stem != _LATERAL[segment] else []
                away = {label: places[label] - means[side + stem] for label in (*own, *add) if label in places}
                known = {
                    label: tuple(map(float, vector)) for label, vector in away.items() if np.isfinite(vector).all()
                }
                if _is_wide(np.array([*known.values()]).reshape(-1, 3)):
                    yield side + stem, VirtualMarker(known)


def _find_beside(side: str, segment: str, means: Mapping[str, Array], unknown: Mapping[str, Array]) -> list[str]:
    """Labels of markers beside a segment of this side."""
    needed = [means.get(side + name) for name in _ENDS[segment]] + [means.get(f"{each}ASI") for each in "LR"]
    if any(place is None for place in needed):
        return []
    begin, end, left, right = (place for place in needed if place is not None)
    line, (least, most) = end - begin, _SHARES[segment]
    if not line @ line > 0:
        return []
    outward = (left - right) * (1 if side == "L" else -1)
    found = []
    for label, place in unknown.items():
        share = (place - begin) @ line / (line @ line)
        is_beside = least <= share <= most and np.linalg.norm(place - begin - share * line) <= _BESIDE
        if is_beside and (place - (left + right) / 2) @ outward > 0:
            found.append(label)
    return found


def _mean(places: Array) -> Array:
    known = places[np.isfinite(places).all(axis=1)]
    mean: Array = known.mean(axis=0) if len(known) else np.full(3, np.nan)
    return mean


def _is_wide(places: Array) -> bool:
    """Whether there are three places (k, 3) that are not on one line."""
    if len(places) < LEAST:
        return False
    spread = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(spread[1] / np.sqrt(len(places)) >= _NARROW)


def _fit(template: Array, positions: Array) -> tuple[Array, Array]:
    """(origin of the template (n, 3), rms distance (n,)) after the best rotation and shift.

    template: (k, 3). positions: (n, k, 3).
    """
    middle, centres = template.mean(axis=0), positions.mean(axis=1)
    own, seen = template - middle, positions - centres[:, None]
    left, _, right = np.linalg.svd(np.einsum("nki,kj->nij", seen, own))
    # A reflection is no movement: the axis of least spread is turned back.
    flip = np.sign(np.linalg.det(left @ right))
    left[:, :, 2] *= flip[:, None]
    turn = left @ right
    away = seen - np.einsum("nij,kj->nki", turn, own)
    return centres - turn @ middle, np.sqrt((away**2).sum(axis=2).mean(axis=1))
