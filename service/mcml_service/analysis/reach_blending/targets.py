"""Requests for a place of the hand: checks, units, and measures of the result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mcml.motion.hub_writer import HubWriter
from mcml.motion.rotation_vectors import angle_between, from_vector, to_vector
from mcml.motion.rotations import inverse, multiply
from mcml.motion.skeleton import Array
from mcml.motion.solving.chains import walk_chain
from mcml_service.analysis.interface import AnalysisError, MadeClip
from mcml_service.analysis.reach_blending.arrival import (
    PELVIS,
    Share,
    Solution,
    find_fade,
    find_weights,
    measure_share,
    solve_contact,
    spread_solution,
)
from mcml_service.analysis.reach_blending.model import Model, Reaching
from mcml_service.analysis.reach_blending.standing import Feet

Method = Literal["blend", "arrive"]
NEAR = 0.001
"""Metres from the target at which the hand is there."""


@dataclass(frozen=True)
class Hand:
    """The hand of a made motion at the contact, in metres.

    frame: the contact, from 0. place: (3,) in the world of the motion. orientation: (4,) x, y, z, w of its joint in
    the world. error: distance from the target. moved: how far parts of the body moved for it. turn_error: degrees from
    the requested orientation. beyond: degrees by which the wrist leaves the range of the examples for it.
    """

    frame: int
    place: Array
    orientation: Array
    error: float | None = None
    moved: Share | None = None
    turn_error: float | None = None
    beyond: float = 0.0


def choose_method(
    method: Method | None, target: Sequence[float] | None, orientation: Sequence[float] | None = None
) -> Method:
    """Return how a motion is made: requests with a target arrive. Raises AnalysisError `no-target`."""
    if orientation is not None and (target is None or method == "blend"):
        raise AnalysisError(
            "no-target",
            "An orientation of the hand needs a target.",
            remedy='Set target to x, y, z in metres, and leave out the method "blend".',
        )
    if method == "arrive" and target is None:
        raise AnalysisError(
            "no-target", 'The method "arrive" needs a target.', remedy="Set target to x, y, z in metres."
        )
    return method or ("blend" if target is None else "arrive")


def measure_hand(model: Model, clip: MadeClip, t2: float, target: Sequence[float] | None) -> Hand | None:
    """Measure where the hand of a clip is at t2 (seconds).

    None where the model does not know its unit or its arm. Raises AnalysisError `unknown-unit`, `no-arm` if this is
    asked for by a target.
    """
    reaching, metres = model.reaching, model.metres
    if reaching is None or metres is None:
        if target is not None:
            raise _unable(model)
        return None
    frame = _contact(clip, t2)
    place, orientation = _hand_at(reaching, clip, frame)
    place = place * metres
    return Hand(
        frame, place, orientation, None if target is None else float(np.linalg.norm(np.asarray(target) - place))
    )


def move_hand(
    model: Model, clip: MadeClip, times: tuple[float, float], target: Sequence[float], clamp: bool, feet: Feet | None
) -> tuple[MadeClip, Hand]:
    """Correct a blended clip so that its hand is at the target at t2. times: t1, t2 in seconds.

    target: metres, in the world of the clip. clamp: take the nearest place instead if the target is out of reach.
    feet: stay where they are if the pelvis moves. Raises AnalysisError `unknown-unit`, `no-arm`, `out-of-reach`.
    """
    reaching, metres = model.reaching, model.metres
    if reaching is None or metres is None:
        raise _unable(model)
    frames = round(times[0] / clip.frame_time), _contact(clip, times[1])
    chain = list(reaching.chain)
    offsets = clip.translations[0, chain]
    goal = np.asarray(target, dtype=np.float64) / metres
    distance = float(np.linalg.norm(goal - _hand_at(reaching, clip, frames[1])[0])) * metres
    made = clip
    for range_of_pelvis in (PELVIS, 0.0):
        root, rotations = made.translations[:, chain[0]], made.rotations[:, chain]
        solution = solve_contact(reaching, offsets, root[frames[1]], rotations[frames[1]], goal, range_of_pelvis)
        if range_of_pelvis and not clamp and solution.missed * metres > NEAR:
            raise _out_of_reach(solution, metres)
        moved, turned = spread_solution(
            reaching, root, rotations, solution, frames, 1.0 / clip.frame_time, find_fade(distance)
        )
        made = _with_chain(made, chain, moved, turned)
        if feet is None or not solution.pelvis.any():
            break
        # Legs that are too short lower the body, for which arm and spine make up in the second round.
        made = feet.bring_back(made, moved - root)
    row = [frames[1]]
    pelvis = made.translations[row, chain[0]] - clip.translations[row, chain[0]]
    own, bent = clip.rotations[row][:, chain], made.rotations[row][:, chain]
    share = measure_share(offsets, own, bent, pelvis, reaching.shoulder)
    place, orientation = _hand_at(reaching, made, frames[1])
    hand = Hand(frames[1], place * metres, orientation)
    error = float(np.linalg.norm(np.asarray(target) - hand.place))
    parts = Share(arm=share.arm * metres, spine=share.spine * metres, pelvis=share.pelvis * metres)
    return made, replace(hand, error=error, moved=parts)


def turn_hand(
    model: Model, clip: MadeClip, times: tuple[float, float], orientation: Sequence[float], hand: Hand
) -> tuple[MadeClip, Hand]:
    """Turn the hand of a clip at its wrist so that it has an orientation at t2.

    orientation: (4,) x, y, z, w of the joint of the hand in the world. The turn grows from t1 and fades after t2 as the
    correction of its place does. A wrist whose channels cannot turn that way is turned as near as they can.
    """
    reaching = model.reaching
    if reaching is None:
        raise _unable(model)
    frame, chain = hand.frame, list(reaching.chain)
    wanted = np.asarray(orientation, dtype=np.float64) / np.linalg.norm(orientation)
    local = clip.rotations[:, chain[-1]]
    above = multiply(hand.orientation, inverse(local[frame]))
    held = HubWriter(clip.skeleton).nearest(chain[-1], multiply(inverse(above), wanted)[None])[0]
    fps = 1.0 / clip.frame_time
    weights = find_weights(len(local), round(times[0] * fps), frame, reaching.hold, fps)
    turn = to_vector(multiply(inverse(local[frame]), held))
    rotations = clip.rotations.copy()
    rotations[:, chain[-1]] = multiply(local, from_vector(weights[:, None] * turn))
    reached = multiply(above, rotations[frame, chain[-1]])
    within = reaching.ranges.of([len(chain) - 1]).limit(held[None], local[frame][None])[0]
    hand = replace(
        hand,
        orientation=reached,
        turn_error=float(np.degrees(angle_between(reached, wanted))),
        beyond=float(np.degrees(angle_between(within, held))),
    )
    return replace(clip, rotations=rotations), hand


def _out_of_reach(solution: Solution, metres: float) -> AnalysisError:
    missed = solution.missed * metres
    return AnalysisError(
        "out-of-reach",
        f"The target is {100 * missed:.1f} cm out of reach: arm, spine and pelvis bring the hand no nearer.",
        remedy="Set clamp for the nearest place, or choose a nearer target or other attributes.",
        distance=round(missed, 6),
        nearest=[round(float(value) * metres, 6) for value in solution.place],
    )


def _with_chain(clip: MadeClip, chain: list[int], root: Array, rotations: Array) -> MadeClip:
    all_rotations, translations = clip.rotations.copy(), clip.translations.copy()
    all_rotations[:, chain] = rotations
    translations[:, chain[0]] = root
    return replace(clip, rotations=all_rotations, translations=translations)


def _contact(clip: MadeClip, t2: float) -> int:
    return min(round(t2 / clip.frame_time), len(clip.rotations) - 1)


def _hand_at(reaching: Reaching, clip: MadeClip, frame: int) -> tuple[Array, Array]:
    """The place (3,) of the hand and the rotation (4,) of its joint in the world."""
    chain = list(reaching.chain)
    root, rotations = clip.translations[[frame], chain[0]], clip.rotations[[frame]][:, chain]
    places, turned = walk_chain(root, rotations, clip.translations[0, chain])
    return places[0, -1], turned[0, -1]


def _unable(model: Model) -> AnalysisError:
    if model.metres is None:
        return AnalysisError(
            "unknown-unit",
            "The unit of length of the model's clips is unknown, so a target in metres has no place.",
            remedy="Set the unit of the clips and fit the model again, or leave the target out.",
        )
    return AnalysisError(
        "no-arm",
        "The model knows no arm: its hand has no upper arm and forearm, or an earlier release fitted it.",
        remedy="Fit the model again, with hand_joint at the end of an arm, or leave the target out.",
    )
