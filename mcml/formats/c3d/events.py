"""Events of C3D files, such as heel strikes, as labels of frames and back. See docs/formats/c3d.md.

Source: The C3D File Format User Guide (c3d.org), "The EVENT Group" and "Header events". Times count from frame 1 of the
capture, which need not be the first frame of the file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from mcml.errors import Notice
from mcml.formats.c3d.parameters import Statements
from mcml.formats.c3d.quantities import plain_text, texts_of
from mcml.formats.format import note
from mcml.formats.text.numbers import is_number

SECTION: Final = "EVENT"
_HEADER_KEY: Final = 12345
_HEADER_MOST: Final = 18
_SIDES: Final = {"l": "Left", "left": "Left", "r": "Right", "right": "Right", "general": "General"}
_SHORT: Final = re.compile(r"(?i)([lr])(hs|to|ic|f[so]|on|off)")
"""A side and a word for strike or off in one, as in `LHS` and `RTO` of Qualisys."""
_GAPS: Final = re.compile(r"[\W_]+")


@dataclass(frozen=True)
class Event:
    """seconds: from frame 1 of the capture. context: "Left", "Right", "General" or "" where the file does not state it.

    label: such as "Foot Strike". subject, description: "" if not stated.
    """

    seconds: float
    context: str
    label: str
    subject: str = ""
    description: str = ""

    def name(self, *, with_subject: bool = False) -> str:
        """The name of its label on a frame, such as `left-foot-strike`, or `event-clap` without a side."""
        context, label = self.context, self.label
        if not context:
            context, label = _side_of(label)
        words = [self.subject if with_subject else "", context or "event", label]
        return "-".join(part for word in words if (part := _GAPS.sub("-", word.lower()).strip("-"))) or "event"

    def frame(self, rate: float) -> int:
        """The number of the nearest frame, 1 for the first of the capture. rate: frames a second."""
        return int(np.rint(self.seconds * rate)) + 1


def _side_of(label: str) -> tuple[str, str]:
    """(side, rest) of a label that begins with a side, as a word or as a letter; ("", label) for others."""
    short = _SHORT.fullmatch(label)
    if short:
        return _SIDES[short[1].lower()], short[2]
    words = _GAPS.split(label, maxsplit=1)
    side = _SIDES.get(words[0].lower(), "")
    return (side, words[1]) if side and len(words) > 1 else ("", label)


def names_of(events: Sequence[Event]) -> list[str]:
    """The names of the labels of events; with the subject where the events are of several."""
    several = len({event.subject for event in events if event.subject}) > 1
    return [event.name(with_subject=several) for event in events]


def read_events(said: Statements, notices: list[Notice]) -> list[Event]:
    """The events of the group EVENT, else those of the header; in the order of the file."""
    labels = [plain_text(text) for text in texts_of(said, "EVENT:LABELS")]
    if not labels:
        return _header_events(said)
    times = said.numbers("EVENT:TIMES")
    used = said.number("EVENT:USED")
    count = min(len(labels), len(times) // 2, len(labels) if used is None else int(max(used, 0)))
    if count < len(labels) and (used is None or count < used):
        note(notices, "warning", f"{len(labels)} events have {len(times) // 2} times: {count} were read")
    columns = {
        name: [plain_text(text) for text in texts_of(said, f"EVENT:{name}")]
        for name in ("CONTEXTS", "SUBJECTS", "DESCRIPTIONS")
    }
    told = {name: [*texts, *[""] * count] for name, texts in columns.items()}
    events = [
        Event(
            60.0 * times[2 * place] + times[2 * place + 1],
            _SIDES.get(told["CONTEXTS"][place].lower(), told["CONTEXTS"][place]),
            labels[place],
            told["SUBJECTS"][place],
            told["DESCRIPTIONS"][place],
        )
        for place in range(count)
    ]
    return _with_times(events, notices)


def _with_times(events: list[Event], notices: list[Notice]) -> list[Event]:
    timed = [event for event in events if np.isfinite(event.seconds) and abs(event.seconds) < 1e9]
    if len(timed) < len(events):
        note(notices, "warning", f"{len(events) - len(timed)} events have no time: left out")
    return timed


def _header_events(said: Statements) -> list[Event]:
    """Up to 18 events in the first block: words 151 to 234, times in seconds, labels of four letters."""
    count = int(said.words[150])
    if said.words[149] != _HEADER_KEY or not 0 < count <= _HEADER_MOST:
        return []
    times = said.machine.floats(said.header[304 : 304 + 4 * count])
    labels = [plain_text(said.header[396 + 4 * place : 400 + 4 * place].strip(b"\0 ")) for place in range(count)]
    return [Event(float(time), "", label) for time, label in zip(times, labels, strict=True) if np.isfinite(time)]


def label_frames(events: Sequence[Event], rate: float, first: int, frames: int) -> dict[int, tuple[str, ...]]:
    """The names of the labels by frame, from 0; events outside of the frames have none.

    rate: frames a second. first: number of the first frame, 1 for the first of the capture.
    """
    found: dict[int, tuple[str, ...]] = {}
    for event, name in zip(events, names_of(events), strict=True):
        place = event.frame(rate) - first
        if 0 <= place < frames and name not in found.get(place, ()):
            found[place] = (*found.get(place, ()), name)
    return found


def section_of(events: Sequence[Event]) -> tuple[str, str]:
    """(name, text) of the section that keeps the exact times: a line for each event, its parts between tabs."""
    rows = (
        (str(np.float32(event.seconds)), event.context, event.label, event.subject, event.description)
        for event in events
    )
    lines = ["\t".join(row) for row in rows]
    return SECTION, "\n".join(line.rstrip("\t") for line in lines)


def kept_events(sections: Iterable[tuple[str, str]]) -> list[Event]:
    """The events that a section keeps; lines of another form are passed over."""
    found = []
    for name, text in sections:
        for line in text.split("\n") if name == SECTION else []:
            seconds, *words = line.split("\t")
            if is_number(seconds) and 1 < len(words) + 1 <= 5:
                found.append(Event(float(seconds), *[*words, *[""] * 4][:4]))
    return found


def events_of_labels(labels: Mapping[int, Sequence[str]], kept: Sequence[Event], rate: float) -> list[Event]:
    """Events for labels of one frame, by the number of the frame: kept ones that still have their label, with their
    exact time and in their order, then new ones.

    rate: frames a second.
    """
    left = {(number, name) for number, names in labels.items() for name in names}
    again = []
    for event, name in zip(kept, names_of(kept), strict=True):
        key = event.frame(rate), name
        if key in left:
            left.remove(key)
            again.append(event)
    return [*again, *(_event_of(name, (number - 1) / rate) for number, name in sorted(left))]


def _event_of(name: str, seconds: float) -> Event:
    """The event of a label that was given here: `left-foot-strike` is Left, Foot Strike."""
    side, rest = _side_of(name)
    return Event(seconds, side or "General", rest.replace("-", " ").title() if side else name)
