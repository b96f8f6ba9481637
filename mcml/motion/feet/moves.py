"""Corrections of feet over time: constant place during contacts, smooth return between them."""

from __future__ import annotations

import numpy as np

from mcml.motion.hub_writer import Flags
from mcml.motion.skeleton import Array
from mcml.numerics.runs import find_true


def hold_moves(toe: Array, ankle: Array, toe_stands: Flags, ankle_stands: Flags, up: Array, most: float) -> Array:
    """(n, 3) moves along the ground after which the standing part of a foot does not slide; NaN where nothing stands.

    toe, ankle: (n, 3) positions. toe_stands, ankle_stands: (n,). While the toe stands it is held, else the ankle: the
    foot rolls from heel to toe without a jump. The mean move of each contact is zero. most: contacts that would be
    moved further than this are left alone: a foot that slides so far means to.
    """
    moves = np.full(toe.shape, np.nan)
    held = _along_ground(_slides(toe, ankle, toe_stands, ankle_stands), up)
    for first, end in find_true(toe_stands | ankle_stands).tolist():
        course = np.zeros((end - first, 3))
        course[1:] = -np.cumsum(held[first : end - 1], axis=0)
        course -= course.mean(axis=0)
        if np.linalg.norm(course, axis=1).max() <= most:
            moves[first:end] = course
    return moves


def _slides(toe: Array, ankle: Array, toe_stands: Flags, ankle_stands: Flags) -> Array:
    """(n - 1, 3) the step of the standing part from each frame to the next."""
    by_toe, by_ankle = toe_stands[1:] & toe_stands[:-1], ankle_stands[1:] & ankle_stands[:-1]
    steps = np.where(by_toe[:, None], np.diff(toe, axis=0), np.diff(ankle, axis=0))
    steps[~(by_toe | by_ankle)] = 0.0
    return steps


def _along_ground(vectors: Array, up: Array) -> Array:
    flat: Array = vectors - np.outer(vectors @ up, up)
    return flat


def spread_moves(moves: Array, fade: int) -> Array:
    """(n, 3) moves without gaps: from the last known move to zero and from zero to the next, over `fade` frames each.

    moves: (n, 3), NaN where unknown. Courses are cubic with continuous speed; where two known moves are nearer than
    twice `fade`, one leads to the other directly.
    """
    known = ~np.isnan(moves[:, 0])
    whole = np.where(known[:, None], moves, 0.0)
    if not known.any():
        return whole
    for first, end in find_true(~known).tolist():
        before = _end_of(moves, first - 1, -1) if first else None
        after = _end_of(moves, end, 1) if end < len(moves) else None
        gap = end - first + 1
        if before is not None and after is not None and gap <= 2 * fade:
            whole[first:end] = _cubic(before, after, gap)
            continue
        if before is not None:
            length = min(fade, gap - 1) + 1
            whole[first : first + length - 1] = _cubic(before, _ZERO, length)
        if after is not None:
            length = min(fade, gap - 1) + 1
            whole[end - length + 1 : end] = _cubic(_ZERO, after, length)
    return whole


_ZERO = (np.zeros(3), np.zeros(3))


def _end_of(moves: Array, row: int, inward: int) -> tuple[Array, Array]:
    """A known move at the edge of a gap, and its change per frame. inward: the way to the next frame outside it."""
    other = row + inward
    if not 0 <= other < len(moves) or np.isnan(moves[other, 0]):
        return moves[row], np.zeros(3)
    return moves[row], (moves[row] - moves[other]) * -inward


def _cubic(start: tuple[Array, Array], end: tuple[Array, Array], length: int) -> Array:
    """(length - 1, 3) the values between two, with their slopes (per frame) at both ends."""
    part = (np.arange(1, length) / length)[:, None]
    (one, pace), (two, pace_after) = start, end
    square, cube = part * part, part**3
    curve: Array = (
        (2 * cube - 3 * square + 1) * one
        + (cube - 2 * square + part) * length * pace
        + (3 * square - 2 * cube) * two
        + (cube - square) * length * pace_after
    )
    return curve
