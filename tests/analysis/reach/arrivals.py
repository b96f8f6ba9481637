"""How near the hands of made reaches come to those of people whose clips the model has not seen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mcml.motion.hub import walked
from mcml.motion.skeleton import Array
from mcml.motion.solving.chains import walk_chain
from mcml_service.analysis.interface import MadeClip, Motion
from mcml_service.analysis.reach_blending.clips import Clip
from mcml_service.analysis.reach_blending.fit import fit
from mcml_service.analysis.reach_blending.model import Model
from mcml_service.analysis.reach_blending.options import options_of
from mcml_service.analysis.reach_blending.synthesis import Made, Wish, synthesize

RATE = 30.0


@dataclass(frozen=True)
class Compared:
    """One clip of a person left out; its hand's place at t2 is the target.

    arrive, blend, nearest: metres from it, of the two methods and of the nearest example. acceleration: 99th percentile
    of the hand's, m/s^2 at 30 frames a second, of arrive, blend and the clip itself. slide: 95th percentile of the
    speed of feet in contact, m/s, of arrive and blend.
    """

    arrive: float
    blend: float
    nearest: float
    acceleration: tuple[float, float, float]
    slide: tuple[float, float]


def leave_people_out(motions: Sequence[Motion], **stated: object) -> Iterator[Compared]:
    """Make the reach of each clip with a model of the other people's clips, and compare."""
    whole = fit(motions, options_of(**stated))  # type: ignore[arg-type]
    for person in sorted({clip.subject for clip in whole.clips}):
        known = [clip.motion for clip in whole.clips if clip.subject != person]
        fitted = fit(known, options_of(**stated))  # type: ignore[arg-type]
        for clip in whole.clips:
            if clip.subject == person:
                near = int(np.argmin(np.abs(fitted.model.attributes - clip.attributes).sum(axis=1)))
                yield _compare(fitted.model, clip, fitted.clips[near])


def _compare(model: Model, clip: Clip, near: Clip) -> Compared:
    metres = model.metres or 1.0
    path, frame = hand_path(model, clip)
    target = path[frame] * metres
    attributes = dict(zip(model.names, clip.attributes.tolist(), strict=True))
    blend, arrived = (
        synthesize(model, Wish(attributes, RATE, target=target.tolist(), clamp=True, method=method))
        for method in ("blend", "arrive")
    )
    other, at = hand_path(model, near)
    step = round(clip.motion.fps / RATE)
    hands = [_hand_of(model, made.clip) * metres for made in (arrived, blend)]
    accelerations = [_most(np.diff(hand, 2, axis=0), 99) * RATE**2 for hand in (*hands, path[::step] * metres)]
    return Compared(
        arrive=_error(arrived),
        blend=_error(blend),
        nearest=float(np.linalg.norm(other[at] * metres - target)),
        acceleration=(accelerations[0], accelerations[1], accelerations[2]),
        slide=(_slide(arrived, arrived.clip) * metres, _slide(arrived, blend.clip) * metres),
    )


def hand_path(model: Model, clip: Clip) -> tuple[Array, int]:
    """The hand of a clip, (F, 3), and its frame at t2."""
    assert model.reaching is not None
    root, rotations = clip.tracks()
    chain = list(model.reaching.chain)
    hand = walk_chain(root, rotations[:, chain], clip.offsets[chain])[0][:, -1]
    return hand, min(round(clip.phases.t2), len(hand) - 1)


def _hand_of(model: Model, clip: MadeClip) -> Array:
    assert model.reaching is not None
    return walked(clip.skeleton, clip.translations, clip.rotations)[0][:, model.reaching.chain[-1]]


def _error(made: Made) -> float:
    assert made.hand is not None
    assert made.hand.error is not None
    return made.hand.error


def _slide(made: Made, clip: MadeClip) -> float:
    """Speed of a clip's feet over the ground (Y is up) during the contacts of a made motion."""
    places = walked(clip.skeleton, clip.translations, clip.rotations)[0][..., [0, 2]]
    steps = [
        np.diff(places[first : last + 1, report.joint], axis=0)
        for report in made.feet
        for first, last in report.contacts
    ]
    return _most(np.concatenate([np.zeros((1, 2)), *steps]), 95) / clip.frame_time


def _most(steps: Array, percent: float) -> float:
    return float(np.percentile(np.linalg.norm(steps, axis=1), percent))
