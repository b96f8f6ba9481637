"""Labels of a clip that are gait events, such as `left-foot-strike`, with their exact times where the file has them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

from mcml.formats.c3d.events import kept_events, names_of
from mcml.laboratory.gait_events import GaitEvent, Kind, Side
from mcml.laboratory.gait_parameters import Exclusion
from mcml.motion.clip import ClipHead, FrameBlock

_WORDS: Final[Mapping[Kind, str]] = {
    "strike": "foot-strike|heel-strike|foot-contact|initial-contact|touch-down|touchdown|strike|hs|ic|fs|on",
    "off": "foot-off|toe-off|off|[tf]o",
}
"""Words of events, without the side."""
_EXCLUDED: Final = re.compile(r"(?:(?P<side>left|right|l|r)-)?gait-exclude")
_COMPARED: Final = 1000
"""Labels, and events of one name, that are compared at most."""
_SIDES: Final[Mapping[str, Side]] = {"left": "left", "l": "left", "right": "right", "r": "right"}
_GAPS: Final = re.compile(r"[\W_]+")
_NAME: Final = re.compile(
    rf"(?:(?P<subject>.+)-)?(?P<side>left|right|l|r)-(?:(?P<strike>{_WORDS['strike']})|(?P<off>{_WORDS['off']}))"
)


def find_gait_labels(labels: Iterable[tuple[int, str]], head: ClipHead, subject: str | None = None) -> list[GaitEvent]:
    """Return the gait events among labels, in order of time; none without a frame rate.

    labels: (frame from 0, name) of the first frame of each. head: of the clip; it keeps the exact times of the events
    of a C3D file. subject: the person, where names begin with one.
    """
    seconds = head.seconds_per_frame()
    if seconds is None:
        return []
    meant = [(frame, name, parts) for frame, name in labels if (parts := read_event_name(name, subject)) is not None]
    part = next((source for source in head.sources if source.part == "c3d"), None)
    kept = kept_events(part.sections) if part is not None else []
    rate = 1 / seconds
    numbers = [(event.frame(rate), name) for event, name in zip(kept, names_of(kept), strict=True)]
    first = _first_number([(frame, name) for frame, name, _ in meant], numbers)
    exact = {key: event.seconds - (key[0] - 1) / rate for event, key in zip(kept, numbers, strict=True)}
    return sorted(
        GaitEvent(frame * seconds + (0.0 if first is None else exact.get((frame + first, name), 0.0)), *parts, "label")
        for frame, name, parts in meant
    )


def _first_number(labels: Sequence[tuple[int, str]], kept: Sequence[tuple[int, str]]) -> int | None:
    """The number in the capture of the first frame of a clip, at which most labels are events of the file; None if no
    number is better than all others. Frames before a cut are no longer counted by the ids of a document.

    labels: (frame from 0, name). kept: (number of the frame in the capture, name).
    """
    by_name: dict[str, list[int]] = {}
    for number, name in kept:
        by_name.setdefault(name, []).append(number)
    counts = Counter(
        number - frame for frame, name in labels[:_COMPARED] for number in by_name.get(name, [])[:_COMPARED]
    )
    best = counts.most_common(2)
    if not best or (len(best) > 1 and best[0][1] == best[1][1]):
        return None
    return best[0][0]


def find_exclusions(labels: Iterable[tuple[int, int, str]]) -> list[Exclusion]:
    """Return the frames whose strides people leave out, from labels such as `gait-exclude` or `left-gait-exclude`.

    labels: (first, last) frames from 0, and the name of each.
    """
    return [
        Exclusion(first, last, _SIDES.get(found["side"] or ""))
        for first, last, name in labels
        if (found := _EXCLUDED.fullmatch(name.lower())) is not None
    ]


def read_spans(blocks: Iterable[FrameBlock]) -> Iterator[tuple[int, int, str]]:
    """(first, last) frames from 0, and the name of each label of a clip."""
    frame = 0
    begun: dict[str, int] = {}
    for block in blocks:
        for names in block.motion_names or [()] * len(block):
            for name in set(begun).difference(names):
                yield begun.pop(name), frame - 1, name
            begun |= {name: frame for name in names if name not in begun}
            frame += 1
    yield from ((first, frame - 1, name) for name, first in begun.items())


def read_labels(blocks: Iterable[FrameBlock]) -> Iterator[tuple[int, str]]:
    """(frame from 0, name) of the first frame of each label of a clip."""
    frame, before = 0, frozenset[str]()
    for block in blocks:
        for row, names in enumerate(block.motion_names or [()] * len(block)):
            yield from ((frame + row, name) for name in names if name not in before)
            before = frozenset(names)
        frame += len(block)


def read_event_name(name: str, subject: str | None = None) -> tuple[Side, Kind] | None:
    """Return the side and the kind of a label's name, None for a name of something else, or of another person.

    >>> read_event_name("left-foot-strike"), read_event_name("r-to"), read_event_name("left-turn")
    (('left', 'strike'), ('right', 'off'), None)
    """
    found = _NAME.fullmatch(name.lower())
    if found is None:
        return None
    if found["subject"] is not None and found["subject"] != _GAPS.sub("-", (subject or "").lower()).strip("-"):
        return None
    return _SIDES[found["side"]], "strike" if found["strike"] else "off"
