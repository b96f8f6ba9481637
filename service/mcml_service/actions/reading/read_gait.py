"""The gait of a document as it is shown."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from mcml.laboratory.gait_events import SIDES, Side
from mcml.laboratory.gait_parameters import PARAMETERS, Summary
from mcml.laboratory.measure_gait import EventSource, Gait
from mcml.motion.bodies.quantities import AskedQuantity
from mcml.motion.skeleton import Array
from mcml_schemas import gait as wire
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.reading.read_quantities import quantity_columns
from mcml_service.clips.bodies import Body
from mcml_service.clips.frame_quantities import FrameQuantities
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

_SIDE: Final = re.compile(r"(?i:left|right)|^[LR](?=[A-Z])")
"""Side of a name such as left_knee, LHEE or LKneeAngles."""
_LETTERS: Final[Mapping[str, Side]] = {"l": "left", "r": "right"}


def read_gait(
    tx: Transaction,
    stored: StoredDocument,
    body: Body,
    source: EventSource,
    subject: str | None,
    asked: Sequence[AskedQuantity],
) -> wire.GaitMeasures:
    """Measure the gait of a document, with cycles of quantities.

    body: of the document. source, subject: as for `measure_gait` and `find_gait_points`. Raises DocumentError without a
    frame time, or if heels, toes or hips are unknown, NotFoundError for joints and measurements that the
    document has not.
    """
    seconds_of(stored)
    quantities = FrameQuantities(tx, stored, body)
    gait = quantities.measure_gait(source, subject)
    values = quantity_columns(quantities, asked, 1, stored.frames)
    cycles = [
        _cycle(gait, quantity, unit, values[:, place], side)
        for place, (quantity, unit) in enumerate(zip(asked, quantities.units(asked), strict=True))
        for side in sides_of(quantity)
    ]
    return _describe(gait, cycles)


def sides_of(asked: AskedQuantity) -> Sequence[Side]:
    """The side of the joints, markers or curves that a quantity names; both where these are of both sides, or none."""
    found = {
        _LETTERS[side[0][0].lower()]
        for argument in asked.arguments
        if (side := _SIDE.search(argument.rpartition(":")[2])) is not None
    }
    return [side for side in SIDES if side in found] or SIDES


def _cycle(gait: Gait, asked: AskedQuantity, unit: str, values: Array, side: Side) -> wire.GaitCycle:
    cycles, mean = gait.cycles(values, side)
    return wire.GaitCycle(
        quantity=asked.text,
        unit=unit,
        side=side,
        n=mean.n,
        gaps=cycles.gaps,
        mean=[value_or_none(value) for value in mean.mean.tolist()],
        sd=[value_or_none(value) for value in mean.sd.tolist()],
    )


def _describe(gait: Gait, cycles: list[wire.GaitCycle]) -> wire.GaitMeasures:
    return wire.GaitMeasures(
        frame_rate=gait.rate,
        clinical=gait.is_clinical,
        running=gait.is_running,
        duty_factor=value_or_none(gait.duty_factor),
        belt=wire.GaitBelt(
            is_belt=gait.belt.is_belt,
            speed=value_or_none(gait.belt.speed),
            sd=value_or_none(gait.belt.sd),
            n=gait.belt.n,
        ),
        points={point: list(names) for point, names in gait.points.items()},
        events=[
            wire.GaitEventItem(
                side=event.side,
                kind=event.kind,
                time=event.seconds,
                frame=round(event.seconds * gait.rate) + 1,
                source=event.source,
                within=value_or_none(gait.uncertainty(event)),
            )
            for event in gait.events
        ],
        strides=[
            wire.GaitStride(
                side=stride.side,
                begin=stride.begin,
                end=stride.end,
                off=stride.off,
                other_off=stride.other_off,
                other_strike=stride.other_strike,
                values={parameter.name: value_or_none(getattr(stride, parameter.name)) for parameter in PARAMETERS},
                rejected=stride.rejected,
            )
            for stride in gait.strides
        ],
        incomplete=dict(gait.incomplete),
        parameters=[
            wire.GaitParameter(
                name=parameter.name,
                unit=parameter.unit,
                how=gait.explain(parameter),
                left=summary_of(gait.summary("left", parameter.name)),
                right=summary_of(gait.summary("right", parameter.name)),
                symmetry=value_or_none(gait.symmetry(parameter.name)),
            )
            for parameter in PARAMETERS
        ],
        cycles=cycles,
        warnings=list(gait.warnings),
    )


def summary_of(summary: Summary) -> wire.GaitSummary:
    return wire.GaitSummary(mean=value_or_none(summary.mean), sd=value_or_none(summary.sd), n=summary.n)


def value_or_none(value: float) -> float | None:
    """A number for JSON: None if it was not measured."""
    return float(value) if np.isfinite(value) else None
