"""The unit and the up axis that an export needs and a document does not state: guessed with a notice, or unknown."""

from __future__ import annotations

from mcml.errors import Notice
from mcml.formats.format import note
from mcml.motion.clip import ClipHead
from mcml.motion.guesses import is_person, size_of_person, up_of_head
from mcml.motion.skeleton import Array


def guess_unit(head: ClipHead, places: Array, notices: list[Notice], otherwise: str) -> float | None:
    """Return the metres of a unit that is not stated, by the size of a person; None for other sizes and bodies.

    places: (J, 3) joints in one frame. otherwise: the reading of programs, for the notice.
    """
    said = head.fields.get("calibration_unit", "").strip()
    what = f"the document's unit of length, {said!r}, is not known" if said else "the document states no unit of length"
    likely = None if said else size_of_person(head, places)
    if likely is None:
        note(notices, "note", f"{what}: its numbers were written as they are, and {otherwise}")
        return None
    unit, metres = likely
    note(notices, "guess", f"{what}: its numbers were taken as {unit}, in which the body has the size of a person")
    return metres


def guess_up(head: ClipHead, places: Array, notices: list[Notice], title: str) -> str | None:
    """Return the up axis that is not stated, if heads and feet show it; else None.

    places: (J, 3) joints in one frame. title: of the format or program that takes Y as up, for the notice.
    """
    likely = up_of_head(head, places) if is_person(head.skeleton) else None
    if likely is None or not likely.sure:
        note(notices, "note", f"the document states no up axis: nothing was turned, and {title} takes Y as up")
        return None
    note(notices, "guess", f"the document states no up axis: {likely.axis} was taken as up, for {likely.why}")
    return likely.axis
