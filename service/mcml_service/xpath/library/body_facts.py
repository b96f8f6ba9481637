"""Facts of the bodies of a group of documents, other than positions."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcml_service.clips.bodies import Body
from mcml_service.xpath.nodes.numbering import Bools, Ints
from mcml_service.xpath.nodes.stored import Columns

GUESSES = ("metres", "up", "floor")
"""Values of a calibration that queries depend on."""
BONES = ("left_up_leg", "right_up_leg", "left_low_leg", "right_low_leg")
"""Bones whose line to the left may be known."""
ZEROS = ("pelvis", "left_foot", "right_foot")
"""Constants of a standing body that may be known."""


@dataclass(frozen=True, eq=False)
class BodyFacts:
    """names: the names of joints that occur together; doubtful: which of them are guesses. kind: of each document which
    of these. unit, times, floor:
    whether its unit, its frame time and its floor are known. guessed: (3, documents) whether each of GUESSES is a
    guess. anatomy: (7, documents) whether each of BONES and ZEROS is known."""

    names: list[list[str]]
    doubtful: list[list[str]]
    kind: Ints
    unit: Bools
    times: Bools
    floor: Bools
    guessed: Bools
    anatomy: Bools

    def __len__(self) -> int:
        return len(self.kind)

    @property
    def nbytes(self) -> int:
        return 20 * len(self) + sum(50 * len(each) for each in self.names) + 200

    def stored(self) -> dict[str, Any]:
        """As columns."""
        known = np.stack([self.unit, self.times, self.floor, *self.guessed, *self.anatomy])
        return {"names": self.names, "doubtful": self.doubtful, "kind": self.kind, "known": known}

    @classmethod
    def restored(cls, found: Columns) -> BodyFacts:
        """Restore facts from their columns."""
        known = np.array(found["known"])
        unit, times, floor = known[:3]
        guessed, anatomy = known[3 : 3 + len(GUESSES)], known[3 + len(GUESSES) :]
        return cls(found["names"], found["doubtful"], found["kind"], unit, times, floor, guessed, anatomy)

    def lacks_anatomy(self, of: Collection[str]) -> Bools:
        """Tell which documents do not know one of some BONES or ZEROS."""
        asked = [name in of for name in (*BONES, *ZEROS)]
        return np.asarray(~self.anatomy[asked].all(axis=0), bool)

    def rests_on_guesses(self, of: Collection[str]) -> Bools:
        """Which documents guess one of some values, by their names in GUESSES."""
        asked = [name in of for name in GUESSES]
        return np.asarray(self.guessed[asked].any(axis=0), bool)

    def in_doubt(self, joints: Callable[[Sequence[str]], Collection[str]]) -> Bools:
        """Tell which documents have a guessed name among joints.

        joints: selects the queried joints from the names of a document.
        """
        doubts = [
            bool(doubtful) and not set(doubtful).isdisjoint(joints(names))
            for names, doubtful in zip(self.names, self.doubtful, strict=True)
        ]
        return np.asarray(np.array(doubts, bool)[self.kind], bool)

    @classmethod
    def of(cls, bodies: Sequence[Body]) -> BodyFacts:
        """Of bodies in the order of their documents."""
        kinds: dict[tuple[tuple[str, ...], tuple[str, ...]], int] = {}
        kind = [kinds.setdefault((body.names, body.doubtful), len(kinds)) for body in bodies]
        known = [
            (b.calibration.metres is not None, b.frame_time is not None, b.calibration.floor is not None)
            for b in bodies
        ]
        unit, times, floor = np.array(known, bool).reshape(-1, 3).T
        origins = [body.calibration.origins for body in bodies]
        guessed = np.array([[each[name].kind == "guessed" for each in origins] for name in GUESSES], bool)
        calibrations = [body.calibration for body in bodies]
        people = [_people_in(body.names) for body in bodies]
        bones = [[_is_known(name, b.bones, who) for b, who in zip(calibrations, people, strict=True)] for name in BONES]
        zeros = [[_is_known(name, b.zeros, who) for b, who in zip(calibrations, people, strict=True)] for name in ZEROS]
        names, doubtful = [list(each) for each, _ in kinds], [list(each) for _, each in kinds]
        anatomy = np.array([*bones, *zeros], bool)
        return cls(names, doubtful, np.array(kind, np.int64), unit, times, floor, guessed, anatomy)

    @classmethod
    def together(cls, parts: Sequence[BodyFacts]) -> BodyFacts:
        """Of documents that follow one another."""
        kinds: dict[tuple[tuple[str, ...], tuple[str, ...]], int] = {}
        kind = [np.empty(0, np.int64)]
        for part in parts:
            pairs = zip(map(tuple, part.names), map(tuple, part.doubtful), strict=True)
            own = [kinds.setdefault(pair, len(kinds)) for pair in pairs]
            kind.append(np.array(own, np.int64)[part.kind])
        nothing = np.empty(0, bool)
        unit = np.concatenate([nothing, *(part.unit for part in parts)])
        times = np.concatenate([nothing, *(part.times for part in parts)])
        floor = np.concatenate([nothing, *(part.floor for part in parts)])
        guessed = np.concatenate([np.empty((len(GUESSES), 0), bool), *(part.guessed for part in parts)], axis=1)
        names, doubtful = [list(each) for each, _ in kinds], [list(each) for _, each in kinds]
        empty = np.empty((len(BONES) + len(ZEROS), 0), bool)
        anatomy = np.concatenate([empty, *(part.anatomy for part in parts)], axis=1)
        return cls(names, doubtful, np.concatenate(kind), unit, times, floor, guessed, anatomy)


def _people_in(names: Sequence[str]) -> list[str]:
    """How the names of the joints of several people begin; [""] for one."""
    hip = BONES[0]
    return [name.removesuffix(hip) for name in names if name.endswith(f":{hip}")] or [""]


def _is_known(name: str, of: Collection[str], people: Sequence[str]) -> bool:
    """Whether everybody in a document has a bone or a zero."""
    return all(person + name in of for person in people)
