"""Generated reach clips as analyses get them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from mcml.motion.hub import HubReader
from mcml_service.analysis.interface import Motion
from mcml_service.analysis.reach_blending.fit import Fitted, fit
from mcml_service.analysis.reach_blending.options import options_of
from mcml_service.demo.reach_clips import OLD, YOUNG, ReachClip, reach_clips
from tests.builders import assign

FEW = ((4,) * 5, (4,) * 5)
"""Trials of a small set of people: 40 clips."""


def motion_of(made: ReachClip) -> Motion:
    head = made.clip.head
    frames = HubReader(head.skeleton).read(next(iter(made.clip.blocks())))
    return Motion(
        document=made.name,
        revision=1,
        name=made.name,
        skeleton=assign(head.skeleton),
        frame_time=head.seconds_per_frame() or 0.0,
        rotations=frames.rotations,
        translations=frames.translations,
        metres=0.01,
        up="Y",
        properties={name: (value, unit) for name, value, unit in head.properties},
    )


@cache
def generated(
    seed: int = 1, fps: float = 30, few: bool = True, noise: bool = True
) -> tuple[list[Motion], list[ReachClip]]:
    young, old = FEW if few else (YOUNG, OLD)
    clips = reach_clips(seed, fps=fps, young=young, old=old, noise=noise)
    return [motion_of(clip) for clip in clips], clips


@cache
def fitted(few: bool = True, method: str = "robust", **options: object) -> Fitted:
    return fit(generated(few=few)[0], options_of(method, **options))  # type: ignore[arg-type]


def labelled(motion: Motion, **values: str) -> Motion:
    """The motion with other properties; the empty text takes one away."""
    merged = dict(motion.properties) | {name: (value, "") for name, value in values.items()}
    return replace(motion, properties={name: pair for name, pair in merged.items() if pair[0]})


def on_grid(motions: Sequence[Motion]) -> list[Motion]:
    """The motions with ages, heights and hip points that are all different and spread evenly."""
    rng = np.random.default_rng(5)
    ages = np.linspace(20, 79, len(motions)).round(2)
    return [
        labelled(motion, age=str(age), height=f"{rng.uniform(150, 190):.2f}", hbp=f"{rng.uniform(200, 400):.2f}")
        for motion, age in zip(motions, ages, strict=True)
    ]
