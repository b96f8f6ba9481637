"""C3D: events are labels of the nearest frames, and leave as events again."""

from __future__ import annotations

import io
import json
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcml.formats import FORMATS
from mcml.formats.c3d.events import Event, events_of_labels, kept_events, section_of
from mcml.formats.format import ReadOptions, SourceFile
from mcml.language.elements import from_head
from mcml.language.reader import read_document
from mcml.language.writer import write_document
from mcml.motion.clip import ClipStream
from mcml.testing import read
from tests.c3d_writer import Value, c3d_bytes, texts

POINTS = np.random.default_rng(1).normal(0, 100, (20, 2, 3)).astype(np.float32).astype(np.float64)
FIRST = 286
RATE = 100.0


def events(labels: list[str], times: list[float], contexts: list[str] | None = None, **more: Value | None) -> bytes:
    pairs = np.array([(0.0, time) for time in times], "<f4")
    parameters: dict[str, Value | None] = {
        "EVENT:USED": (2, (), struct.pack("<H", len(labels))),
        "EVENT:LABELS": texts(*labels),
        "EVENT:TIMES": (4, (2, len(times)), pairs.tobytes()),
    }
    if contexts is not None:
        parameters["EVENT:CONTEXTS"] = texts(*contexts)
    parameters |= {f"EVENT:{name}": value for name, value in more.items()}
    return c3d_bytes(POINTS, None, labels=["a", "b"], parameters=parameters, first=FIRST, rate=RATE)


def clip_of(data: bytes) -> ClipStream:
    return read(FORMATS["c3d"], {"c3d": data}, ReadOptions())


def labels_of(clip: ClipStream) -> list[tuple[int, str]]:
    """(number of the frame, label)."""
    found = []
    for block in clip.blocks():
        names = block.motion_names or [()] * len(block)
        found += [(int(number), name) for number, some in zip(block.ids, names, strict=True) for name in some]
    return found


def test_times_count_from_the_first_frame_of_the_capture() -> None:
    clip = clip_of(events(["Foot Strike", "Foot Off"], [2.87, 2.9149], ["Right", "Left"]))
    assert labels_of(clip) == [(288, "right-foot-strike"), (292, "left-foot-off")]
    assert any("2 events are labels of the nearest frames" in notice.what for notice in clip.notices)
    assert kept_events(clip.head.sources[0].sections) == [
        Event(2.87, "Right", "Foot Strike"),
        Event(2.9149, "Left", "Foot Off"),
    ]


@pytest.mark.parametrize(
    ("label", "context", "name"),
    [
        ("LHS", None, "left-hs"),
        ("RTO", None, "right-to"),
        ("L_HS", None, "left-hs"),
        ("Left Foot Strike", None, "left-foot-strike"),
        ("right event", None, "right-event"),
        ("Clap", None, "event-clap"),
        ("Landing", None, "event-landing"),
        ("Event", "General", "general-event"),
        ("Foot Strike", "left", "left-foot-strike"),
        ("", "Right", "right"),
    ],
)
def test_names_of_labels(label: str, context: str | None, name: str) -> None:
    clip = clip_of(events([label or " ", "x"], [2.87, 9.0], None if context is None else [context, context]))
    assert labels_of(clip) == [(288, name)]
    assert any("1 events are outside of the frames" in notice.what for notice in clip.notices)


def test_events_of_several_subjects_begin_with_theirs() -> None:
    data = events(["Foot Strike"] * 2, [2.86, 2.87], ["Left"] * 2, SUBJECTS=texts("Ann", "Ben"))
    assert labels_of(clip_of(data)) == [(287, "ann-left-foot-strike"), (288, "ben-left-foot-strike")]


def test_minutes_count_and_what_is_not_used_does_not() -> None:
    long = np.array([0.0, 2.88, 1.0, -57.1, 0.0, 2.9], "<f4").tobytes()
    data = events(["a", "b", "c"], [0, 0, 0], TIMES=(4, (6,), long), USED=(2, (), struct.pack("<H", 2)))
    assert labels_of(clip_of(data)) == [(289, "event-a"), (291, "event-b")]


def test_events_of_the_header() -> None:
    data = bytearray(c3d_bytes(POINTS, None, labels=["a", "b"], first=FIRST, rate=RATE))
    struct.pack_into("<HH", data, 298, 12345, 2)
    struct.pack_into("<2f", data, 304, 2.9, 2.88)
    data[396:404] = b"RHS LTO\0"
    assert labels_of(clip_of(bytes(data))) == [(289, "left-to"), (291, "right-hs")]


def test_events_without_times_are_left_out() -> None:
    data = events(["a", "b"], [2.87], TIMES=(4, (2, 1), np.array([0, 2.87], "<f4").tobytes()))
    clip = clip_of(data)
    assert labels_of(clip) == [(288, "event-a")]
    assert any("2 events have 1 times" in notice.what for notice in clip.notices)
    nan = events(["a", "b"], [np.nan, 2.87])
    assert labels_of(clip_of(nan)) == [(288, "event-b")]


def test_a_document_keeps_times_and_words() -> None:
    clip = clip_of(events(["Foot Strike"], [2.8749], ["Right"], SUBJECTS=texts("Ann"), DESCRIPTIONS=texts("by force")))
    (block,) = list(clip.blocks())
    document = b"".join(write_document(from_head(clip.head), len(block), None, [block], clip.head.skeleton.names))
    again = clip_of(b"".join(FORMATS["c3d"].write(read_document(io.BytesIO(document)).clip, "c3d")))
    assert kept_events(again.head.sources[0].sections) == kept_events(clip.head.sources[0].sections)
    assert labels_of(again) == labels_of(clip) == [(288, "right-foot-strike")]


def test_labels_that_were_given_or_taken_away_are_so_in_the_file() -> None:
    clip = clip_of(events(["Foot Strike", "Foot Off"], [2.87, 2.91], ["Right", "Left"]))
    (block,) = list(clip.blocks())
    names = [()] * len(block)
    names[2], names[9], names[15], names[16] = ("right-foot-strike",), ("left-toe-off", "hop"), ("walk",), ("walk",)
    changed = ClipStream(clip.head, lambda: iter([replace(block, motion_names=names)]), len(block), [])
    again = clip_of(b"".join(FORMATS["c3d"].write(changed, "c3d")))
    assert labels_of(again) == [(288, "right-foot-strike"), (295, "general-hop"), (295, "left-toe-off")]
    assert [(event.context, event.label) for event in kept_events(again.head.sources[0].sections)] == [
        ("Right", "Foot Strike"),
        ("General", "hop"),
        ("Left", "Toe Off"),
    ]
    assert any("labels of several frames are left out (walk)" in notice.what for notice in changed.notices)


TEXTS = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc")), max_size=20).map(str.strip)


@settings(deadline=None)
@given(
    st.lists(
        st.builds(
            Event, st.floats(0, 1e4, width=32), st.sampled_from(["", "Left", "Right", "General"]), TEXTS, TEXTS, TEXTS
        )
    )
)
def test_sections_keep_events(many: list[Event]) -> None:
    kept = [event for event in many if event.label or event.context]
    again = kept_events([section_of(kept)])
    assert [replace(event, seconds=float(np.float32(event.seconds))) for event in again] == kept


def test_labels_without_kept_events_stand_at_the_time_of_their_frame() -> None:
    assert events_of_labels({31: ("left-foot-strike",)}, [], 100.0) == [Event(0.3, "Left", "Foot Strike")]


@pytest.mark.parametrize("name", ["hc030a05", "s4_am_gait04", "mh0222_bp06", "treadmill_events", "ja1gait35"])
def test_files_of_laboratories(shared: Path, name: str) -> None:
    expected = json.loads((shared / "lab" / "expected.json").read_text())[f"{name}.c3d"]
    content = (shared / "lab" / f"{name}.c3d").read_bytes()
    clip = FORMATS["c3d"].read({"c3d": SourceFile(name, io.BytesIO(content))}, ReadOptions())
    first = expected["first_frame"]
    wanted = [
        (place + first, f"{side} {label}".lower().replace(" ", "-"))
        for place, (_, side, label) in zip(expected["event_frames_from_first"], expected["events"], strict=True)
    ]
    assert labels_of(clip) == sorted(wanted)
    again = clip_of(b"".join(FORMATS["c3d"].write(clip, "c3d")))
    assert labels_of(again) == labels_of(clip)
    times = [event.seconds for event in kept_events(again.head.sources[0].sections)]
    np.testing.assert_allclose(sorted(times), sorted(time for time, _, _ in expected["events"]), atol=1e-3)
