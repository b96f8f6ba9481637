"""The tables of figures in docs/analyses/reach.md: `python -m benchmarks.reach_figures`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mcml_service.analysis.interface import Motion
from mcml_service.analysis.reach_blending.blend import invert as inverse_of
from mcml_service.analysis.reach_blending.blend import leave_out, linear_left_out, nearest_left_out
from mcml_service.analysis.reach_blending.evaluation import predictions, reconstruction
from mcml_service.analysis.reach_blending.fit import Fitted, fit
from mcml_service.analysis.reach_blending.options import options_of
from mcml_service.analysis.reach_blending.phases import find_phases
from mcml_service.analysis.reach_blending.quaternion_tracks import angle_between
from mcml_service.demo.reach_clips import reach_clips
from tests.analysis.reach.arrivals import hand_path, leave_people_out
from tests.analysis.reach.hdm05 import read_reaches
from tests.analysis.reach.reach_motions import motion_of
from tests.conftest import shared_folder

WAYS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("paper", {"method": "paper", "duplicates": "mean"}),
    ("robust", {}),
    ("global", {"space": "global"}),
)


def row(*cells: object) -> None:
    print("| " + " | ".join(f"{cell:.3g}" if isinstance(cell, float) else str(cell) for cell in cells) + " |")


def in_metres(motions: Sequence[Motion]) -> list[Motion]:
    return [replace(motion, translations=motion.translations / 100, metres=1.0) for motion in motions]


def percent(found: Fitted) -> tuple[str, str, str]:
    shares = found.components.cumulative()
    poses = f"{100 * found.pose_shares[:, -1].mean():.2f}" if found.pose_shares.size else ""
    return poses, f"{100 * shares[0]:.1f}", f"{100 * shares[9]:.1f}"


def components(name: str, motions: Sequence[Motion], **stated: object) -> None:
    for way, options in WAYS:
        found = fit(motions, options_of(**{**options, **stated}))
        errors, unit = reconstruction(found), 1000 * (found.model.metres or 1.0)
        row(f"{name}, {way}", *percent(found), errors.joints, errors.phase_joint, errors.hand * unit, len(found.clips))


def signs(motions: Sequence[Motion]) -> None:
    for align in ("none", "max", "reference"):
        found = fit(motions, options_of("paper", duplicates="mean", sign_align=align))
        row(align, *percent(found)[1:], reconstruction(found).joints)


def people(motions: Sequence[Motion]) -> None:
    cases = (
        *WAYS[:2],
        ("robust, s = 2 x mean neighbour, lam = 0", {"lam": 0.0, "duplicates": "mean"}),
        ("robust, interpolate", {"interpolate": True}),
    )
    for way, options in cases:
        if "2 x mean" in way:
            options = {**options, "s": 2 * fit(motions, options_of(lam=1.0, s=1.0)).model.neighbour}
        found = fit(motions, options_of(**options))
        unit = 1000 * (found.model.metres or 1.0)
        for found_way in predictions(found):
            if found_way.left_out == "subject":
                errors = found_way.errors
                numbers = errors.joints, errors.phase_joint, errors.hand * unit, *found_way.times.tolist()
                row(way, found_way.predictor, *(float(number) for number in numbers))


def seeds() -> None:
    for seed in range(1, 9):
        found = fit([motion_of(clip) for clip in reach_clips(seed)], options_of())
        by_name = {way.predictor: way.errors for way in predictions(found) if way.left_out == "subject"}
        cells = [
            f"{by_name[name].joints:.3f}, {10 * by_name[name].hand:.1f}" for name in ("model", "linear", "nearest")
        ]
        row(seed, *cells, f"{found.selected.s / found.model.neighbour:.2g}", found.selected.lam)


def law() -> None:
    """Predictions for people left out, against the law without any person's or trial's deviation."""
    found = fit([motion_of(clip) for clip in reach_clips(1)], options_of())
    ideal = fit(
        [motion_of(clip) for clip in reach_clips(1, deviations=0.0, noise=False)], options_of(knots=found.model.knots)
    )
    chosen, model = found.selected, found.model
    groups = chosen.subjects or []
    predicted = {
        "model": leave_out(inverse_of(chosen.centres, chosen.s, chosen.lam, 1), chosen.coefficients, groups),
        "linear": linear_left_out(chosen.centres, chosen.coefficients, 1, groups),
        "nearest": nearest_left_out(chosen.centres, chosen.coefficients, groups),
    }
    truth = ideal.sampled
    hand = found.ruler.hand(truth.root, truth.rotations)

    def compared(root: np.ndarray, rotations: np.ndarray) -> tuple[float, float, float]:
        angles = angle_between(rotations, truth.rotations)
        missed = np.linalg.norm(found.ruler.hand(root, rotations) - hand, axis=2).mean()
        return float(angles.mean()), float(angles[:, :, found.body.phase_joint].mean()), 10 * float(missed)

    for name, coefficients in predicted.items():
        row(name, *compared(*model.motion_space.motions(model.mean + coefficients @ model.basis)))
    row("the measured clips themselves", *compared(found.sampled.root, found.sampled.rotations))


def phase_times() -> None:
    for fps in (30, 60, 120):
        for method in ("robust", "paper"):
            within, bias = [], []
            for seed in (1, 2, 3):
                clips = reach_clips(seed, fps=fps)
                place = 12
                for clip in clips:
                    motion = motion_of(clip)
                    found = find_phases(motion.rotations[:, place], motion.fps, method)
                    away = (np.array(found.times) - np.array(clip.times)) * 30 / fps
                    within.append(np.abs(away).max() <= 2)
                    bias.append(away)
            mean = np.mean(bias, axis=0)
            row(fps, method, f"{100 * np.mean(within):.1f}", f"{mean[0]:+.2f}", f"{mean[1]:+.2f}")


def arrivals(name: str, motions: Sequence[Motion], **stated: object) -> None:
    """Medians and greatest values of centimetres to the target, m/s^2 of the hand and cm/s of standing feet."""
    compared = list(leave_people_out(motions, **stated))
    for what, factor, columns in (
        ("hand, cm: arrive, blend, nearest", 100, [(each.arrive, each.blend, each.nearest) for each in compared]),
        ("acceleration, m/s2: arrive, blend, clip", 1, [each.acceleration for each in compared]),
        ("standing feet, cm/s: arrive, blend", 100, [each.slide for each in compared]),
    ):
        table = factor * np.array(columns)
        cells = [f"{middle:.3g} ({most:.3g})" for middle, most in zip(np.median(table, 0), table.max(0), strict=True)]
        row(name, what, len(compared), *cells)


def chosen_by_hand(motions: Sequence[Motion]) -> None:
    """Hands of people left out, cm, where the place of the hand is the attributes: two ways to choose the width."""
    whole = fit(motions, options_of(attributes=("target",), align="start"))
    metres = whole.model.metres or 1.0
    labelled = []
    for clip in whole.clips:
        path, frame = hand_path(whole.model, clip)
        place = {name: (repr(float(value)), "m") for name, value in zip("xyz", path[frame] * metres, strict=True)}
        labelled.append(replace(clip.motion, properties={**clip.motion.properties, **place}))
    for count in (10, 20):
        for choose_by in ("coefficients", "hand"):
            options = options_of(attributes=tuple("xyz"), align="start", components=count, choose_by=choose_by)
            ways = predictions(fit(labelled, options))
            errors = next(way.errors for way in ways if (way.left_out, way.predictor) == ("subject", "model"))
            row(count, choose_by, 100 * metres * errors.contact)


def main() -> None:
    motions = [motion_of(clip) for clip in reach_clips(1)]
    assert motions[0].skeleton.names[12] == "right_up_arm"
    print("components: ten eigenposes %, first %, ten eigenmotions %, joints deg, arm deg, hand mm, clips")
    components("generated", motions)
    components("generated, root in m", in_metres(motions))
    folder = shared_folder()
    if folder is not None:
        reaches = read_reaches(folder / "asfamc" / "hdm05_reach")
        components("HDM05", reaches, attributes=("target",))
        print("hands of people left out: median (greatest)")
        arrivals("HDM05", reaches, attributes=("target",), align="start")
        arrivals("HDM05 where they stand", reaches, attributes=("target",))
        print("place of the hand as attributes: components, choose_by, hands of people left out, cm")
        chosen_by_hand(reaches)
    arrivals("generated", motions)
    print("signs of eigenposes: first %, ten %, joints deg")
    signs(motions)
    print("people left out: predictor, joints deg, arm deg, hand mm, t1, t2, end frames")
    people(motions)
    print("seeds: model, linear, nearest (joints deg, hand mm), s / neighbour, lam")
    seeds()
    print("against the law: joints deg, arm deg, hand mm")
    law()
    print("phase times: fps, method, % within 2 frames of 1/30 s, bias of t1, t2")
    phase_times()


if __name__ == "__main__":
    main()
