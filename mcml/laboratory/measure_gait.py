"""Measure the gait of a body: events, strides, parameters by side, cycles, and how sure all of it is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from mcml.errors import DocumentError
from mcml.laboratory.gait_contacts import find_contacts
from mcml.laboratory.gait_cycles import Cycles, MeanCycle, mean_cycle, normalise_cycles
from mcml.laboratory.gait_events import (
    KINDS,
    RUNNING,
    SIDES,
    EventsFromPositions,
    GaitEvent,
    Side,
    WalkerPaths,
    between,
    choose_events,
    find_events,
    measure_duty,
    times_of,
)
from mcml.laboratory.gait_parameters import (
    BELT,
    EXCLUDED,
    OUTLIER_RULE,
    BeltSpeed,
    Exclusion,
    Parameter,
    Stride,
    Summary,
    exclude_strides,
    measure_belt,
    measure_strides,
    reject_outliers,
    summarise,
    symmetry,
)
from mcml.laboratory.gait_points import GaitPoints, Walker, find_gait_points, find_paths
from mcml.laboratory.plate_feet import prefer_plates
from mcml.motion.bodies.stretch import Stretch
from mcml.motion.skeleton import Array, Skeleton

EventSource: TypeAlias = Literal["auto", "labels", "positions"]

CLINICAL_RATE: Final = 50.0
"""Frames a second from which gait events may be called clinical."""
FASTEST: Final = 10_000.0
"""Frames a second up to which a filter of 1 Hz is exact in double precision."""
WITHIN: Final = 0.045
"""Seconds within which 95 % of the events that positions tell are right (docs/analyses/gait.md)."""
_NEAR = 0.15
"""Seconds within which an event of the positions is that of a label."""
_MOVES = 0.25
"""Leg lengths that the pelvis of somebody who walks travels."""


@dataclass(frozen=True, eq=False)
class Gait:
    """The gait of a body.

    events: strikes and offs in order of time, each with its source. strides: in order of time; rejected ones say by
    which rule. incomplete: number of strides by side without parameters, because an event is missing. duty_factor: the
    share of a stride in which its foot is on the ground, NaN without a stride. is_running: None without a stride. belt:
    the speed of planted feet. points: names of the markers or joints that heels, toes and hips are. rate: frames a
    second. warnings: reasons why values are less sure, or missing.
    """

    events: tuple[GaitEvent, ...]
    strides: tuple[Stride, ...]
    incomplete: Mapping[Side, int]
    duty_factor: float
    is_running: bool | None
    belt: BeltSpeed
    points: Mapping[str, tuple[str, ...]]
    rate: float
    warnings: tuple[str, ...]

    @property
    def is_clinical(self) -> bool:
        """Whether there are enough frames a second for clinical use: 50 or more."""
        return self.rate >= CLINICAL_RATE

    def uncertainty(self, event: GaitEvent) -> float:
        """Seconds within which an event is right in 95 of 100 cases; NaN for labels and plates, taken as given."""
        frame = 0.0 if self.is_clinical else 1 / self.rate
        return WITHIN + frame if event.source == "positions" else float("nan")

    def summary(self, side: Side, name: str) -> Summary:
        """Summarise a parameter of a side, such as "stride_length", over its strides that are not rejected."""
        return summarise(self.strides, side, name)

    def symmetry(self, name: str) -> float:
        """Return the symmetry index of a parameter in percent, NaN where a side is unknown."""
        left, right = (self.summary(side, name).mean for side in SIDES)
        return symmetry(left, right)

    def explain(self, parameter: Parameter) -> str:
        """Tell how a parameter was computed."""
        if not self.belt.is_belt or parameter.name not in ("stride_length", "step_length", "speed"):
            return parameter.how
        return f"{parameter.how}; plus the way of the belt, {self.belt.speed:.3f} m/s by planted feet"

    def contacts(self, side: Side, frames: int) -> Array:
        """(n,) of a foot in each of so many frames: 1 from strike to off, 0 from off to strike, NaN elsewhere."""
        return find_contacts(self.events, side, self.rate, frames)

    def cycles(self, values: Array, side: Side) -> tuple[Cycles, MeanCycle]:
        """Cut a quantity (n,) of all frames into the cycles of a side, 0 to 100 %, from strike to strike.

        Incomplete and rejected strides are left out, as between their strikes another one may be missing. Strides with
        a gap are left out too, and counted.
        """
        intervals = [
            (stride.begin, stride.end) for stride in self.strides if stride.side == side and not stride.rejected
        ]
        cycles = normalise_cycles(values, self.rate, intervals)
        return cycles, mean_cycle(cycles.curves)


@dataclass(frozen=True, eq=False)
class GaitEvents:
    """The events of a body's gait, with the paths that they were found in.

    events: in order of time, as `find_gait_events` chooses them. from_positions: all that positions tell. walker: the
    paths of feet and pelvis, with the names of their points. metric: these paths in metres. is_moving: whether the
    body walks. rate: frames a second.
    """

    events: tuple[GaitEvent, ...]
    from_positions: EventsFromPositions
    walker: Walker
    metric: WalkerPaths
    is_moving: bool
    rate: float


def find_gait_events(
    points: GaitPoints,
    stretch: Stretch,
    labels: Sequence[GaitEvent] = (),
    source: EventSource = "auto",
    find_plates: Callable[[WalkerPaths], Sequence[GaitEvent]] | None = None,
) -> GaitEvents:
    """Find the strikes and offs of a body.

    stretch: all of its frames, with the joints or markers of the points. labels: events that the clip states. source:
    "auto" takes the strikes, and the offs, of a side from labels if it has any, else from positions, of which those on
    force plates are replaced. find_plates: returns events of plates for the feet in metres. Raises DocumentError if
    the frame rate is unknown, or above 10,000 frames a second.
    """
    if stretch.frame_time is None:
        raise DocumentError("The frame rate is unknown, so gait has no times.", remedy="State the frame time.")
    rate = 1 / stretch.frame_time
    if rate > FASTEST:
        raise DocumentError(
            f"Gait is measured up to {FASTEST:g} frames a second; this clip has {rate:.4g}.",
            remedy="Correct the frame time, or resample the clip.",
        )
    walker = find_paths(points, stretch, rate)
    found = find_events(walker.paths)
    is_moving = bool(found.events) or _is_moving(walker.paths)
    trusted = labels if is_moving else ()
    metric = _scale(walker.paths, stretch.calibration.metres_per_step)
    on_plates = find_plates(metric) if find_plates is not None and source == "auto" and is_moving else ()
    seen = prefer_plates(found.events, on_plates)
    events = choose_events([*([] if source == "positions" else [trusted]), *([] if source == "labels" else [seen])])
    return GaitEvents(events, found, walker, metric, is_moving, rate)


def measure_gait(
    points: GaitPoints,
    stretch: Stretch,
    labels: Sequence[GaitEvent] = (),
    source: EventSource = "auto",
    find_plates: Callable[[WalkerPaths], Sequence[GaitEvent]] | None = None,
    exclusions: Sequence[Exclusion] = (),
) -> Gait:
    """Measure the gait of a body.

    exclusions: of strides. The other arguments, and errors, are those of `find_gait_events`.
    """
    found = find_gait_events(points, stretch, labels, source, find_plates)
    events, metric, rate, walker = found.events, found.metric, found.rate, found.walker
    belt = measure_belt(metric, events)
    measured = measure_strides(metric, events, belt.speed if belt.is_belt else 0.0)
    strides = exclude_strides(reject_outliers(measured.strides, rate), exclusions, rate)
    duty = measure_duty(events)
    warnings = [
        *_warn_of_events(found, labels, source),
        *_warn_of_body(points, walker, stretch, rate),
        *_warn_of_strides(strides, measured.incomplete, belt, is_running=duty < RUNNING),
    ]
    is_running = bool(duty < RUNNING) if np.isfinite(duty) else None
    return Gait(events, strides, measured.incomplete, duty, is_running, belt, walker.points, rate, tuple(warnings))


def find_walker(
    skeleton: Skeleton, read: Callable[[frozenset[str]], Stretch], subject: str | None = None
) -> WalkerPaths:
    """Find feet and pelvis in metres, NaN where the unit is unknown.

    read: returns all frames with the joints or markers of these names. subject: as for `find_gait_points`. Raises
    DocumentError without a frame rate, or if heels, toes or hips are unknown.
    """
    points = find_gait_points(skeleton, subject)
    stretch = read(points.names)
    if stretch.frame_time is None:
        raise DocumentError("The frame rate is unknown, so gait has no times.", remedy="State the frame time.")
    return _scale(find_paths(points, stretch, 1 / stretch.frame_time).paths, stretch.calibration.metres_per_step)


def _scale(paths: WalkerPaths, factor: float) -> WalkerPaths:
    """The same in another unit; all unknown with NaN."""
    return replace(
        paths,
        heels={side: factor * path for side, path in paths.heels.items()},
        toes={side: factor * path for side, path in paths.toes.items()},
        pelvis=factor * paths.pelvis,
    )


def _is_moving(paths: WalkerPaths) -> bool:
    """Whether the pelvis travels."""
    level = paths.pelvis - np.outer(paths.pelvis @ paths.up, paths.up)
    seen = level[np.isfinite(level).all(axis=1)]
    return len(seen) > 0 and float(np.linalg.norm(np.ptp(seen, axis=0))) > _MOVES * paths.leg


def _warn_of_events(found: GaitEvents, labels: Sequence[GaitEvent], source: EventSource) -> Iterable[str]:
    events, is_moving = found.events, found.is_moving
    if labels and not is_moving:
        yield f"{len(labels)} labels of events were not used: nobody walks in this clip"
    if not events and is_moving:
        yield "no strike or off was found: feet and pelvis are not seen long enough, or do not swing"
    sources = {event.source for event in events}
    for side in SIDES:
        for kind in KINDS:
            own = [event for event in events if (event.side, event.kind) == (side, kind)]
            from_plates = sum(event.source == "plate" for event in own)
            if own and own[0].source != "label" and "label" in sources:
                yield f"{side} {kind}s are from positions: the clip has no labels of them"
            if 0 < from_plates < len(own):
                yield f"{from_plates} of {len(own)} {side} {kind}s are from force plates, the others from positions"
            if own and own[0].source == "label" and source == "auto":
                times = times_of(own, side, kind)
                others = [
                    at
                    for at in times_of(found.from_positions.events, side, kind)
                    if not between(times, at - _NEAR, at + _NEAR)
                ]
                if others:
                    yield f"{len(others)} more {side} {kind}s are in the positions, without labels: they were not used"


def _warn_of_body(points: GaitPoints, walker: Walker, stretch: Stretch, rate: float) -> Iterable[str]:
    calibration = stretch.calibration
    if rate < CLINICAL_RATE:
        yield f"{rate:.4g} frames a second are too few for clinical use, which needs {CLINICAL_RATE:g}"
    unit = calibration.origins["metres"]
    if calibration.metres is None:
        yield f"lengths and speeds are unknown, because the unit is: {unit.reason}"
    elif unit.kind == "guessed":
        yield f"the unit is guessed: {unit.reason}"
    if calibration.origins["up"].kind == "guessed":
        yield f"the up axis is guessed: {calibration.origins['up'].reason}"
    if points.are_joints:
        yield "events are those of ankles and toe joints, which are not heel and toe"
    for side in SIDES:
        heel = walker.points[f"{side}_heel"]
        if heel in points.ankles:
            yield f"{' and '.join(heel)} is in the place of the {side} heel"
    if stretch.skipped:
        yield f"the first {stretch.skipped} frames are a pose before the motion and were not used"


def _warn_of_strides(
    strides: Sequence[Stride], incomplete: Mapping[Side, int], belt: BeltSpeed, *, is_running: bool
) -> Iterable[str]:
    for side in SIDES:
        if incomplete[side]:
            yield f"{incomplete[side]} {side} strides lack an event, or have them in no order, and are left out"
    for rule in (OUTLIER_RULE, EXCLUDED):
        if rejected := sum(stride.rejected == rule for stride in strides):
            yield f"{rejected} strides are left out of means and cycles: {rule}"
    if belt.speed > BELT and not belt.is_belt:
        yield f"planted feet move at {belt.speed:.3f} m/s although the body travels: feet slide, and lengths include it"
    if belt.is_belt:
        sure = "; of runs, lengths are sure within 10 %" if is_running else ""
        yield f"lengths and speeds are those on a belt of {belt.speed:.3f} m/s, as planted feet move{sure}"
