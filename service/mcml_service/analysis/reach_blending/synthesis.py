"""A motion made for attributes, and how far it is to be trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mcml.motion.feet.locking import FootReport
from mcml.motion.skeleton import Array, EndSite, Skeleton
from mcml_service.analysis.interface import AnalysisError, MadeClip
from mcml_service.analysis.reach_blending.clips import check_ranges
from mcml_service.analysis.reach_blending.model import Model
from mcml_service.analysis.reach_blending.quaternion_tracks import continuous, unit
from mcml_service.analysis.reach_blending.standing import find_feet
from mcml_service.analysis.reach_blending.targets import (
    NEAR,
    Hand,
    Method,
    choose_method,
    measure_hand,
    move_hand,
    turn_hand,
)
from mcml_service.analysis.reach_blending.time_normalisation import positions, read_rotations, read_values
from mcml_service.analysis.reach_blending.trust import TOUCHING, most_influential, nearest_in_hull

Support = Literal["inside", "gap", "outside"]
SPARSE = 2.0
STRAIGHT = 1.0
"""Degrees from which an orientation is missed."""
OFF_PLANE = 0.05
"""Deviations of the examples."""


@dataclass(frozen=True)
class Wish:
    """A request for a motion.

    template: document whose body is used, None: the nearest clip's. clamp: take the nearest attributes inside, and the
    nearest place of the hand. target: place of the hand at t2, metres in the world of the motion. orientation: (4,) of
    the hand then, x, y, z, w in the world. method: None: arrive if there is a target.
    """

    attributes: Mapping[str, float]
    fps: float | None = None
    template: str | None = None
    extrapolate: bool = True
    clamp: bool = False
    force: bool = False
    name: str | None = None
    target: Sequence[float] | None = None
    orientation: Sequence[float] | None = None
    method: Method | None = None


@dataclass(frozen=True)
class Made:
    """A synthesised motion and its facts.

    used: attributes after clamping. times: (3,) seconds. weights: (index of the clip, weight), the ten largest.
    template: index of the clip whose body it has. in_gaps: names of attributes. warnings: (code, sentence). hand: None
    where the model does not know its unit or its arm. feet: of each leg that is held, by method "arrive".
    """

    clip: MadeClip
    used: dict[str, float]
    times: tuple[float, float, float]
    support: Support
    in_hull: bool
    nn_ratio: float
    in_gaps: tuple[str, ...]
    weights: tuple[tuple[int, float], ...]
    template: int
    warnings: tuple[tuple[str, str], ...]
    method: Method
    hand: Hand | None
    feet: tuple[FootReport, ...]


def synthesize(model: Model, wish: Wish) -> Made:
    """The motion at the attributes of a wish.

    Raises AnalysisError `missing-attribute`, `unknown-attribute`, `attribute-not-a-number`, `unit-suspect`,
    `outside-hull`, `time-order`, `unknown-template`, `no-target`, `unknown-unit`, `no-arm`, `out-of-reach`.
    """
    method = choose_method(wish.method, wish.target, wish.orientation)
    asked = _read_request(model, wish)
    warnings = _not_modelled(model, asked)
    x = model.attribute_space.coordinates(asked[None])[0]
    nearest = nearest_in_hull(model.centres, x)
    extent = float(np.ptp(model.centres, axis=0).max(initial=0.0)) or 1.0
    inside = bool(np.linalg.norm(nearest - x) <= TOUCHING * extent)
    if not inside and wish.clamp:
        x = nearest
        asked = np.where(model.attribute_space.scale > 0, model.attribute_space.attributes(x[None])[0], asked)
        warnings.append(
            ("clamped", "The attributes are outside the range of the examples; the nearest values inside are used.")
        )
    elif not inside and not wish.extrapolate:
        raise AnalysisError(
            "outside-hull",
            "The attributes are outside the range of the examples.",
            remedy="Set clamp for the nearest ones inside, or extrapolate to go on.",
        )
    in_gaps = tuple(
        name
        for name, value, gaps in zip(model.names, asked, model.gaps, strict=True)
        if any(low < value < high for low, high in gaps)
    )
    distances = np.linalg.norm(model.centres - x, axis=1)
    ratio = float(distances.min() / model.neighbour) if model.neighbour > 0 else 0.0
    if ratio > SPARSE:
        warnings.append(("sparse-region", f"The nearest example is {ratio:.1f} times as far as examples usually are."))
    if in_gaps:
        warnings.append(("in-gap", f"No example has {' or '.join(in_gaps)} near the requested one."))
    template = _template(model, wish, int(np.argmin(distances)))
    clip, times, at = _motion(model, x, wish, template)
    weights = model.weights(x)
    hand: Hand | None
    reports: tuple[FootReport, ...] = ()
    if method == "arrive" and wish.target is not None:
        feet = None
        if model.contacts is not None and model.up is not None:
            feet = find_feet(clip, model.contacts, weights, model.up, at)
            clip, reports = feet.hold(clip)
        clip, hand = move_hand(model, clip, times[:2], wish.target, wish.clamp, feet)
        if wish.orientation is not None:
            clip, hand = turn_hand(model, clip, times[:2], wish.orientation, hand)
        if feet is not None:
            slides = feet.measure(clip)
            reports = tuple(replace(report, after=slide) for report, slide in zip(reports, slides, strict=True))
        warnings += _about_hand(hand)
    else:
        hand = measure_hand(model, clip, times[1], wish.target)
    first_clip = {int(example): place for place, example in reversed(list(enumerate(model.example_of)))}
    # Clamped requests were outside of the examples too: the answer shows it in the used attributes.
    hull = inside or wish.clamp
    return Made(
        clip=replace(clip, properties=_properties(model, asked)),
        used=dict(zip(model.names, asked.tolist(), strict=True)),
        times=times,
        support="outside" if not hull else "gap" if in_gaps else "inside",
        in_hull=hull,
        nn_ratio=ratio,
        in_gaps=in_gaps,
        weights=tuple((first_clip[int(place)], float(weights[place])) for place in most_influential(weights)),
        template=template,
        warnings=tuple(warnings),
        method=method,
        hand=hand,
        feet=reports,
    )


def _about_hand(hand: Hand | None) -> list[tuple[str, str]]:
    found = []
    if hand is not None and hand.error is not None and hand.error > NEAR:
        found.append(
            ("out-of-reach", f"The hand stays {100 * hand.error:.1f} cm from the target, at the nearest place.")
        )
    if hand is not None and hand.turn_error is not None and hand.turn_error > STRAIGHT:
        found.append(("wrist-cannot-turn", f"The hand stays {hand.turn_error:.0f} degrees from its orientation."))
    if hand is not None and hand.beyond > STRAIGHT:
        found.append(
            ("wrist-beyond-examples", f"The wrist turns {hand.beyond:.0f} degrees farther than in the examples.")
        )
    return found


def _read_request(model: Model, wish: Wish) -> Array:
    unknown = sorted(set(wish.attributes) - set(model.names))
    if unknown:
        raise AnalysisError(
            "unknown-attribute",
            f"The model has no attribute {unknown[0]!r}.",
            remedy=f"It has {', '.join(model.names)}.",
        )
    missing = [name for name in model.names if name not in wish.attributes]
    if missing:
        raise AnalysisError(
            "missing-attribute", f"The attribute {missing[0]!r} is not stated.", remedy=f"State {', '.join(missing)}."
        )
    values = np.array([float(wish.attributes[name]) for name in model.names])
    if not np.isfinite(values).all():
        name = model.names[int(np.argmin(np.isfinite(values)))]
        raise AnalysisError("attribute-not-a-number", f"The attribute {name!r} is not a finite number.")
    if not wish.force:
        check_ranges(model.names, values.tolist(), "as requested")
    return values


def _not_modelled(model: Model, asked: Array) -> list[tuple[str, str]]:
    space = model.attribute_space
    constant = [
        name
        for name, value, mean, scale in zip(model.names, asked, space.mean, space.scale, strict=True)
        if scale == 0 and abs(value - mean) > 1e-9 * max(abs(mean), 1.0)
    ]
    warnings = [
        ("attribute-not-modelled", f"All examples have the same {name}: it makes no difference.") for name in constant
    ]
    if space.dropped and space.off_plane(asked[None])[0] > OFF_PLANE:
        warnings.append(("attributes-off-plane", "The examples' attributes are collinear; the requested ones are not."))
    return warnings


def _template(model: Model, wish: Wish, nearest: int) -> int:
    if wish.template is None:
        return int(np.argmax(model.example_of == nearest))
    for place, source in enumerate(model.sources):
        if source.document == wish.template:
            return place
    raise AnalysisError(
        "unknown-template",
        f"The model was not fitted to a document {wish.template!r}.",
        remedy="Name one of the clips that the model uses, or none for the nearest.",
    )


def _motion(model: Model, x: Array, wish: Wish, template: int) -> tuple[MadeClip, tuple[float, float, float], Array]:
    """Return frames at the requested rate, t1, t2 and end, and the samples (F,) of frames.

    Frame i is shown at i / fps seconds.
    """
    times = model.phase_times(x)
    root, rotations = model.samples(x)
    fps = wish.fps or model.base_fps
    frames = round(float(times[2]) * fps / model.base_fps) + 1
    shown = np.minimum(np.arange(frames) * model.base_fps / fps, times[2])
    at = positions(model.knots, times, shown, legacy=model.legacy_time_map)
    turned = continuous(unit(read_rotations(rotations, at)))
    translations = np.broadcast_to(model.offsets[template], (frames, *model.offsets[template].shape)).copy()
    translations[:, 0] = read_values(root, at)
    t1, t2, end = (float(time) / model.base_fps for time in times)
    asked = ", ".join(f"{name} {wish.attributes[name]:g}" for name in model.names)
    bounds = (round(t1 * fps), round(t2 * fps))
    spans = (("prepare", 0, bounds[0]), ("reach", bounds[0] + 1, bounds[1]), ("settle", bounds[1] + 1, frames - 1))
    clip = MadeClip(
        name=wish.name or f"reach, {asked}",
        skeleton=body_of(model, template),
        frame_time=1.0 / fps,
        rotations=turned,
        translations=translations,
        metres=model.metres,
        up=model.up,
        description=f"Made for {asked}; body of {model.sources[template].name}.",
        labels=tuple(span for span in spans if 0 <= span[1] <= span[2] < frames),
    )
    return clip, (t1, t2, end), at


def _properties(model: Model, used: Array) -> tuple[tuple[str, str, str], ...]:
    return tuple(
        (name, repr(round(float(value), 6)), unit_name)
        for name, value, unit_name in zip(model.names, used, model.units, strict=True)
    )


def body_of(model: Model, clip: int) -> Skeleton:
    """The skeleton with the bones of a clip."""
    tips = iter(model.tips[clip])
    joints = []
    for index, joint in enumerate(model.skeleton.joints):
        sites = tuple(EndSite(_triple(next(tips)), site.name, site.before) for site in joint.end_sites)
        joints.append(replace(joint, offset=_triple(model.offsets[clip, index]), end_sites=sites))
    return Skeleton(tuple(joints))


def _triple(vector: Array) -> tuple[str, str, str]:
    x, y, z = (repr(round(float(value), 9) + 0.0) for value in vector)
    return x, y, z
