"""From clips to a model, with everything worth knowing about the way."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcml.motion.hub import rest_of
from mcml.motion.skeleton import Array
from mcml.motion.solving.arms import arm_length, find_hinge
from mcml.motion.solving.joint_ranges import learn_ranges
from mcml_service.analysis.interface import AnalysisError, Motion, Progress, silent
from mcml_service.analysis.reach_blending.accuracy import Ruler, Sampled, hand_error_of
from mcml_service.analysis.reach_blending.arrival import SHORTEST_FADE
from mcml_service.analysis.reach_blending.attribute_space import (
    AttributeSpace,
    attribute_space,
    duplicates,
    gaps,
    same_place,
)
from mcml_service.analysis.reach_blending.blend import fit_blend
from mcml_service.analysis.reach_blending.clips import (
    Body,
    Clip,
    check_ranges,
    common_body,
    differing_bones,
    find_arm,
    minority,
    read_clip,
    turning_freely,
    unit_of,
)
from mcml_service.analysis.reach_blending.durations import about_cuts, to_time_values
from mcml_service.analysis.reach_blending.model import Model, Reaching, Source, cardinal_of
from mcml_service.analysis.reach_blending.motion_spaces import (
    EigenposeSpace,
    GlobalPoseSpace,
    MotionSpace,
    TangentSpace,
    Track,
)
from mcml_service.analysis.reach_blending.options import Options
from mcml_service.analysis.reach_blending.phases import angular_speed
from mcml_service.analysis.reach_blending.principal_components import Components, principal_components
from mcml_service.analysis.reach_blending.quaternion_tracks import align_tracks, mean_rotations
from mcml_service.analysis.reach_blending.selection import Selected, examples_needed, examples_of, select
from mcml_service.analysis.reach_blending.standing import learn_contacts
from mcml_service.analysis.reach_blending.time_normalisation import (
    Knots,
    instants,
    mean_knots,
    read_rotations,
    read_values,
)

MIXED_UNITS = "unit-mismatch"
HELD = 0.1
"""Of the arm's length: within this the hand holds its place."""


@dataclass(frozen=True)
class Excluded:
    """A motion that the model does not use. code, reason: why. speed: (F,) of the phase joint, to look at."""

    motion: Motion
    code: str
    reason: str
    speed: Array


@dataclass(frozen=True)
class Fitted:
    """A model and its making.

    clips: those used, by document. times: (N, 3) frames at base_fps. example_of: (N,). pose_shares: (N, k) of each
    clip's variance (paper), (1, k) of all frames (global), empty for the tangent space. coefficients: (N, K).
    warnings: (code, sentence).
    """

    model: Model
    body: Body
    clips: tuple[Clip, ...]
    excluded: tuple[Excluded, ...]
    times: Array
    pose_shares: Array
    components: Components
    sampled: Sampled
    ruler: Ruler
    selected: Selected
    warnings: tuple[tuple[str, str], ...]


def fit(motions: Sequence[Motion], options: Options, progress: Progress = silent) -> Fitted:
    """Fit the model of labelled motions, in any order.

    Raises AnalysisError with the names of docs/analyses/reach.md.
    """
    ordered = sorted(motions, key=lambda motion: motion.document)
    body, places = common_body(ordered, options)
    clips, excluded = _read(ordered, places, body, options, progress)
    units = tuple(unit_of([clip.motion for clip in clips], name) for name in options.attributes)
    if not options.force:
        for clip in clips:
            try:
                check_ranges(options.attributes, clip.attributes.tolist(), f"in {clip.motion.name}")
            except AnalysisError as error:
                error.details["leave_out"] = [clip.motion.document]
                raise
    warnings = [warning for clip in clips for warning in clip.warnings]
    metres = _metres(clips)
    offsets = np.stack([clip.offsets for clip in clips]) if clips else np.zeros((0, len(body.skeleton), 3))
    if clips and (wide := differing_bones(body, offsets)):
        warnings.append(("bones-differ", f"Bones differ by over 20 % between clips: {', '.join(wide)}."))

    attributes = np.array([clip.attributes for clip in clips]).reshape(len(clips), len(options.attributes))
    scarce = scarcity(options.attributes, attributes, _labels(clips, options))
    with _explain(scarce):
        examples_needed(attributes, options, [excluded_.reason for excluded_ in excluded])
    space = attribute_space(attributes, options.scaling)
    warnings += [*scarce, *_about_attributes(space, options)]
    x = space.coordinates(attributes)
    groups = _examples(x, options, clips)

    times = np.array([np.array(clip.phases.times) * options.base_fps / clip.motion.fps for clip in clips])
    knots = options.knots or mean_knots(times)
    warnings += about_cuts(times, options.base_fps) if options.log_times else []
    progress("sampling", 0.3)
    reference = mean_rotations(sum((clip.moments for clip in clips), np.zeros(())))
    sampled = _sample(clips, reference, knots)
    ruler = Ruler(body.phase_joint, body.chain, offsets[_middle(x)], knots[1])
    progress("components", 0.4)
    motion_space, vectors, shares = _vectors(clips, reference, knots, sampled, offsets, options)
    if isinstance(motion_space, TangentSpace) and motion_space.farthest(vectors) > 2.8:
        warnings.append(("far-from-reference", "A joint turns by over 160° from its mean: its blends may go round."))
    components = principal_components(vectors, options.components, options.variance, in_place=True)
    del vectors
    progress("cross-validation", 0.6)
    with _explain(scarce):
        selected = select(
            x,
            groups,
            components.coefficients,
            to_time_values(times, options.log_times, options.base_fps),
            _labels(clips, options),
            options,
            hand_error_of(motion_space, components, sampled, ruler),
        )
    warnings += selected.warnings
    coefficients = fit_blend(selected.centres, selected.coefficients, selected.s, selected.lam, options.degree)
    time_blend = fit_blend(selected.centres, selected.time_values, selected.time_s, selected.time_lam, options.degree)
    model = Model(
        skeleton=turning_freely(body.skeleton),
        offsets=offsets,
        tips=_tips(clips, places[0]),
        metres=metres,
        up=next((clip.motion.up for clip in clips if clip.motion.up), None),
        sources=tuple(_source(clip) for clip in clips),
        names=options.attributes,
        units=units,
        attributes=attributes,
        attribute_space=space,
        example_of=examples_of(selected.groups),
        gaps=tuple(tuple(gaps(column)) for column in attributes.T),
        neighbour=selected.neighbour,
        motion_space=motion_space,
        mean=components.mean,
        basis=components.basis,
        coefficients=coefficients,
        times=time_blend,
        cardinal=cardinal_of(coefficients),
        knots=knots,
        base_fps=options.base_fps,
        log_times=options.log_times,
        legacy_time_map=options.legacy_time_map,
        contacts=_contacts(clips, body, reference, knots, offsets, selected.groups),
        reaching=_reaching(body, sampled, reference, ruler, times, knots, options),
    )
    return Fitted(
        model, body, tuple(clips), tuple(excluded), times, shares, components, sampled, ruler, selected, tuple(warnings)
    )


def _read(
    motions: Sequence[Motion], places: Sequence[NDArray[np.intp]], body: Body, options: Options, progress: Progress
) -> tuple[list[Clip], list[Excluded]]:
    clips: list[Clip] = []
    excluded: list[Excluded] = []
    for count, (motion, kept) in enumerate(zip(motions, places, strict=True)):
        if count % 50 == 0:
            progress("reading", 0.3 * count / len(motions))
        try:
            clips.append(read_clip(motion, kept, body, options))
        except AnalysisError as error:
            # Times that a person set are a request, not a fault of the clip.
            if options.on_bad_clip == "error" or error.code == "phase-order":
                error.what = f"{motion.name} ({motion.document}): {error.what}"
                error.details |= {"document": motion.document, "leave_out": [motion.document]}
                raise
            joint = np.nan_to_num(motion.rotations[:, kept[body.phase_joint]])
            speed = angular_speed(joint, motion.fps, options.phase_method)
            reason = f"{error.what} {error.remedy}" if error.remedy else error.what
            excluded.append(Excluded(motion, error.code, reason, speed))
    return clips, excluded


def _metres(clips: Sequence[Clip]) -> float | None:
    stated = sorted({clip.motion.metres for clip in clips if clip.motion.metres is not None})
    if len(stated) > 1:
        raise AnalysisError(
            MIXED_UNITS,
            f"The clips are in units of {' and '.join(f'{value:g}' for value in stated)} m.",
            remedy="Choose clips in one unit of length.",
            leave_out=minority({c.motion.document: c.motion.metres for c in clips if c.motion.metres is not None}),
        )
    return stated[0] if stated else None


def scarcity(names: Sequence[str], attributes: Array, subjects: Sequence[str] | None) -> list[tuple[str, str]]:
    """Return (code, sentence) if the clips have only two values of an attribute, or two people.

    attributes: (N, A). subjects: people, (N,), None if unknown.
    """
    reasons = []
    for name, column in zip(names, attributes.T, strict=True):
        values = np.unique(column)
        if len(values) == 2:
            low, high = (f"{value:g}" for value in values)
            reasons.append(
                (
                    "two-values",
                    f"{name} has only two values in the clips, {low} and {high}: there are no examples between and "
                    f"beyond them. Add clips with other values of {name}, or remove it from the attributes.",
                )
            )
    if subjects is not None and len(people := sorted(set(subjects))) == 2:
        reasons.append(
            (
                "two-people",
                f"The clips are of two people, {people[0]} and {people[1]}: effects of a person and of an attribute "
                "cannot be separated, and no person is left for cross-validation. Add clips of more people, or remove "
                'attributes that are constant within a person; subject="" leaves single clips out instead.',
            )
        )
    return reasons


@contextmanager
def _explain(scarce: Sequence[tuple[str, str]]) -> Iterator[None]:
    """Explain too few examples by their small variety, not by the number of clips, if that is the cause."""
    try:
        yield
    except AnalysisError as error:
        if error.code != "too-few-examples" or not scarce:
            raise
        why = " ".join(sentence for _, sentence in scarce)
        raise AnalysisError(
            error.code, f"{error.what} {why}", remedy=error.remedy, reasons=[c for c, _ in scarce]
        ) from error


def _about_attributes(space: AttributeSpace, options: Options) -> list[tuple[str, str]]:
    warnings = [
        ("constant-attribute", f"All clips have the same {name}: the model cannot vary it.")
        for name, scale in zip(options.attributes, space.scale, strict=True)
        if scale == 0
    ]
    if space.dropped:
        warnings.append(
            ("collinear-attributes", f"The attributes depend on each other: {space.dropped} direction(s) left out.")
        )
    return warnings


def _examples(x: Array, options: Options, clips: Sequence[Clip]) -> list[list[int]]:
    """Groups of clips with equal attributes, first clips in order; single ones are groups of one."""
    groups = duplicates(x)
    if groups and options.duplicates == "error":
        pairs = [[clips[row].motion.name for row in group] for group in groups]
        raise AnalysisError(
            "duplicate-attributes",
            f"{len(groups)} sets of clips have the same attributes, among them {' and '.join(pairs[0][:2])}.",
            remedy='Set duplicates to "mean" to average them, or use the robust method.',
            groups=pairs,
            leave_out=[clips[row].motion.document for group in groups for row in group[1:]],
        )
    return same_place(groups, len(x))


def _labels(clips: Sequence[Clip], options: Options) -> list[str] | None:
    """Return the person in each clip, None if unknown."""
    subjects = [clip.subject for clip in clips]
    told = options.subject and any(clip.subject != clip.motion.document for clip in clips)
    return subjects if told and len(set(subjects)) > 1 else None


def _tracks(clips: Sequence[Clip], reference: Array, knots: Knots) -> Iterator[Track]:
    for clip in clips:
        root, rotations = clip.tracks()
        yield Track(root, align_tracks(rotations, reference), instants(knots, clip.phases.times))


def _sample(clips: Sequence[Clip], reference: Array, knots: Knots) -> Sampled:
    samples, joints = knots[2] + 1, len(reference)
    root, rotations = np.empty((len(clips), samples, 3)), np.empty((len(clips), samples, joints, 4))
    for place, track in enumerate(_tracks(clips, reference, knots)):
        root[place] = read_values(track.root, track.at)
        rotations[place] = read_rotations(track.rotations, track.at)
    return Sampled(root, rotations)


def _vectors(
    clips: Sequence[Clip], reference: Array, knots: Knots, sampled: Sampled, offsets: Array, options: Options
) -> tuple[MotionSpace, Array, Array]:
    """The motion space, the rows (N, D) of the clips in it, and the variance that poses keep."""
    if options.space == "tangent":
        length = float(np.linalg.norm(offsets, axis=2).mean(axis=0).max()) or 1.0
        tangent = TangentSpace(reference, length)
        return tangent, tangent.vectors(sampled.root, sampled.rotations), np.empty((0, 0))
    tracks = list(_tracks(clips, reference, knots))
    if options.space == "global":
        pose_space, shares = GlobalPoseSpace.of(tracks, options.pose_components)
        return pose_space, pose_space.vectors(tracks), shares[None]
    eigenposes = EigenposeSpace(len(reference), options.pose_components)
    vectors, pose_shares = eigenposes.vectors(tracks, options.sign_align)
    return eigenposes, vectors, pose_shares


def _reaching(
    body: Body, sampled: Sampled, reference: Array, ruler: Ruler, times: Array, knots: Knots, options: Options
) -> Reaching | None:
    """Learn what targets need from the sampled clips; None where the hand has no arm of two bones."""
    arm = find_arm(body)
    if arm is None:
        return None
    joints = list(body.chain)
    rotations = sampled.rotations[:, :, joints].reshape(-1, len(joints), 4)
    ranges = learn_ranges(rotations, reference[joints])
    hands = ruler.hand(sampled.root, sampled.rotations)
    near = HELD * arm_length(ruler.offsets[joints], arm)
    rest = (times[:, 2] - times[:, 1]) / options.base_fps >= SHORTEST_FADE
    hinge = find_hinge(rotations, ruler.offsets[joints], arm)
    return Reaching(body.chain, *arm, hinge, ranges, middle_hold(hands[rest, knots[1] :], near))


def _contacts(
    clips: Sequence[Clip], body: Body, reference: Array, knots: Knots, offsets: Array, groups: Sequence[list[int]]
) -> Array | None:
    """Contacts of the feet of examples: means of their clips."""
    up = next((clip.motion.up for clip in clips if clip.motion.up), None)
    tracks, times = _tracks(clips, reference, knots), [clip.motion.frame_time for clip in clips]
    contacts = learn_contacts(body.skeleton, tracks, offsets, times, up)
    return None if contacts is None else np.stack([contacts[rows].mean(axis=0) for rows in groups])


def middle_hold(hands: Array, near: float) -> float:
    """Return the median share of frames, of hands (N, n, 3), before a hand is farther than near from its first place.

    Without clips, 1: no hand is known to leave.
    """
    if not len(hands):
        return 1.0
    left = np.linalg.norm(hands - hands[:, :1], axis=2) > near
    frames = np.where(left.any(axis=1), left.argmax(axis=1) - 1, hands.shape[1] - 1)
    return float(np.median(frames / max(hands.shape[1] - 1, 1)))


def _middle(x: Array) -> int:
    """The clip nearest to the mean of the attributes: its body measures the hand's errors."""
    return int(np.argmin(np.sum((x - x.mean(axis=0)) ** 2, axis=1)))


def _tips(clips: Sequence[Clip], places: NDArray[np.intp]) -> Array:
    """(N, T, 3) ends of chains; those of the first clip where a clip has others."""
    kept = set(places.tolist())
    tips = [[vector for joint, vector in rest_of(clip.motion.skeleton).tips if joint in kept] for clip in clips]
    count = len(tips[0])
    return np.array([own if len(own) == count else tips[0] for own in tips]).reshape(len(clips), count, 3)


def _source(clip: Clip) -> Source:
    return Source(clip.motion.document, clip.motion.revision, clip.motion.name, clip.subject)
