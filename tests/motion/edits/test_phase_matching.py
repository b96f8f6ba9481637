"""Walks that meet in the same phase of a step: the frames that are left out, and those that are none's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mcml
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.edits.composing import Composed, Piece, compose
from mcml.motion.edits.phase_matching import WINDOW
from mcml.motion.edits.splicing import Placement
from mcml.motion.edits.transitions import Style
from mcml.motion.frames import in_columns, rows_of
from mcml.motion.units import reading_of
from tests import fuzz
from tests.motion.matching.curved_walks import curved_walk, with_names
from tests.motion.test_frames import same_bits, whole

RATE = 60.0
STYLES: list[Style] = ["bridge", "crossfade", "inertial"]
FRAMES = 18


def walk(degrees: float = 0.0) -> tuple[ClipStream, FrameBlock, float]:
    """A walk, its frames, and its cycle in frames: the shift by which the poses repeat best."""
    clip = with_names(curved_walk(degrees))
    block = whole(clip)
    turning = [place for place, (joint, _) in enumerate(clip.head.skeleton.columns()) if joint > 0]
    values = in_columns(block, clip.head.skeleton.columns())[:, turning]
    apart = [np.abs(values[shift:] - values[:-shift]).mean() for shift in range(30, 120)]
    return clip, block, 30.0 + int(np.argmin(apart))


def compose_two(clip: ClipStream, one: FrameBlock, two: FrameBlock, style: Style, match_phase: bool = True) -> Composed:
    pieces = [Piece(one, 1 / RATE), Piece(two, 1 / RATE)]
    reading = reading_of(clip.head)
    settings = {"transition": FRAMES, "style": style, "reading": reading, "lengthen": False}
    return compose(clip.head.skeleton, pieces, 1 / RATE, match_phase=match_phase, **settings)


@pytest.mark.parametrize("style", STYLES)
@fuzz.examples(8)
@given(first=st.integers(100, 160), second=st.integers(0, 120))
def test_walks_meet_in_phase(style: Style, first: int, second: int) -> None:
    clip, block, cycle = walk()
    one, two = rows_of(block, 0, first), rows_of(block, second, len(block))
    made = compose_two(clip, one, two, style)
    [seam], (_, _, last, _), (_, begin, _, offset) = made.seams, *made.spans
    assert max(seam.left_out) <= (WINDOW * RATE) + FRAMES
    # In the source, frames of the transition pass between the last frame before it and the first one after it.
    passed = (second + offset) - last - (begin - last)
    assert abs((passed + cycle / 2) % cycle - cycle / 2) <= 2


@pytest.mark.parametrize("style", STYLES)
def test_spans_name_frames_of_the_source(style: Style) -> None:
    clip, block, _ = walk(30.0)
    pieces = [rows_of(block, 0, 130), rows_of(block, 40, 280)]
    made = compose_two(clip, *pieces, style)
    turning = [place for place, (joint, _) in enumerate(clip.head.skeleton.columns()) if joint > 0]
    assert len(made.spans) == 2
    for piece, first, last, offset in made.spans:
        source = in_columns(pieces[piece], clip.head.skeleton.columns())[offset : offset + last - first + 1]
        assert same_bits(made.block.values[first : last + 1][:, turning], source[:, turning])


def test_nothing_is_left_out_where_one_stands() -> None:
    clip, block, _ = walk()
    still = replace(block, values=np.repeat(block.values[:1], len(block), axis=0))
    for pair in [(block, still), (still, block), (still, still)]:
        assert compose_two(clip, *pair, "bridge").seams[0].left_out == (0, 0)
    placed = Piece(rows_of(block, 20, 200), 1 / RATE, placement=Placement(np.array([0.0, 1.0, 0.0])))
    pieces = [Piece(rows_of(block, 0, 150), 1 / RATE), placed]
    reading = reading_of(clip.head)
    made = compose(clip.head.skeleton, pieces, 1 / RATE, transition=FRAMES, match_phase=True, reading=reading)
    assert made.seams[0].left_out == (0, 0)
    short = compose_two(clip, rows_of(block, 0, 3), rows_of(block, 50, 53), "crossfade")
    assert short.seams[0].left_out == (0, 0)


@pytest.mark.slow
def test_feet_slide_less_between_real_walks(shared: Path) -> None:
    files = sorted((shared / "bvh" / "bandai").glob("*_walk_*.bvh"))
    clips = [mcml.read(path)._clip for path in files]  # with MCML's names of joints
    chance = np.random.default_rng(1)
    slides: dict[bool, list[float]] = {True: [], False: []}
    for _ in range(24):
        pieces, reading = [], reading_of(clips[0].head)
        for place in chance.choice(len(clips), 2, replace=False):
            block = whole(clips[place])
            first = int(chance.integers(0, max(1, len(block) - 60)))
            pieces.append(Piece(rows_of(block, first, min(first + 60, len(block))), 1 / 30))
        for match_phase, found in slides.items():
            settings = {"transition": 9, "match_phase": match_phase, "reading": reading}
            [seam] = compose(clips[0].head.skeleton, pieces, 1 / 30, **settings).seams
            assert seam.slide is not None
            found.append(seam.slide)
    assert np.median(slides[True]) < 0.8 * np.median(slides[False])
