"""The gait of several trials together, beside that of other trials: a second session, or a normal band."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from mcml.errors import McmlError, RequestError
from mcml.laboratory.gait_cycles import Cycles
from mcml.laboratory.gait_events import SIDES, Side
from mcml.laboratory.gait_parameters import PARAMETERS, symmetry
from mcml.laboratory.gait_trials import Group, Trial
from mcml.laboratory.measure_gait import EventSource
from mcml.laboratory.report_curves import ReportCurve, choose_curves
from mcml.language.elements import to_head
from mcml.motion.bodies.limb_angles import angle_names
from mcml.motion.bodies.quantities import AskedQuantity, asked_quantity
from mcml.motion.skeleton import Convention
from mcml_schemas import gait as wire
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.reading.read_gait import sides_of, summary_of, value_or_none
from mcml_service.actions.reading.read_quantities import quantity_columns
from mcml_service.clips.bodies import Body
from mcml_service.clips.frame_quantities import FrameQuantities, read_measurements
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

MOST_TRIALS = 50
"""Documents of a comparison."""

_NAMED = 3
"""Quantities in a warning."""
COLUMNS = ("group", "document", "name", "quantity", "axis", "unit", "side", "stride", "percent", "value")
"""Of the long form of cycles."""

Names: TypeAlias = Sequence[str] | None


@dataclass(frozen=True, eq=False)
class Comparison:
    """own: the trials in question. compare: others, such as of another session. reference: those of the normal band."""

    curves: tuple[ReportCurve, ...]
    own: Group
    compare: Group | None
    reference: Group | None

    @property
    def groups(self) -> dict[str, Group]:
        """By name, as far as they were asked for."""
        named = {"own": self.own, "compare": self.compare, "reference": self.reference}
        return {name: group for name, group in named.items() if group is not None}


def compare_gait(
    tx: Transaction,
    read_body: Callable[[StoredDocument], Body],
    documents: Sequence[str],
    compare: Names,
    reference: Names,
    quantities: Names,
    source: EventSource,
) -> Comparison:
    """Measure the gait of trials.

    documents, compare, reference: ids, or names of collections. read_body: returns the body of one. quantities: of the
    cycles; without, those of a report that the first trial with any can have. Trials that cannot be measured have
    warnings. Raises RequestError for no or too many documents, NotFoundError for unknown ones.
    """
    chosen = [list(dict.fromkeys(tx.saved.expand(names or ()))) for names in (documents, compare, reference)]
    count = sum(map(len, chosen))
    if not chosen[0] or count > MOST_TRIALS:
        raise RequestError(
            f"The comparison has {count} documents." if count else "The comparison has no documents.",
            remedy=f"Choose 1 to {MOST_TRIALS} documents, or run the analysis `gait` for any number.",
        )
    stored = [[tx.documents.get(uuid) for uuid in uuids] for uuids in chosen]
    if quantities:
        curves: tuple[ReportCurve, ...] = tuple(_curves_of(quantities))
    else:
        curves = next((some for each in stored[0] if (some := _default_curves(tx, each))), ())
    asked = [
        asked_quantity(text) for text in dict.fromkeys(text for each in curves for text in each.quantities.values())
    ]
    groups = [
        _measure_group(tx, read_body, group, asked, source) if group or not number else None
        for number, group in enumerate(stored)
    ]
    own = groups[0]
    assert own is not None
    return Comparison(curves, own, groups[1], groups[2])


def _default_curves(tx: Transaction, stored: StoredDocument) -> tuple[ReportCurve, ...]:
    labels = [
        each.name for each in read_measurements(tx, stored).describe() if each.function == "quantity" and each.known
    ]
    skeleton = to_head(tx.heads.document(stored), stored.frame_time).skeleton
    markers = any(joint.convention is Convention.MARKER for joint in skeleton.joints)
    return choose_curves(labels, () if markers else angle_names())


def _curves_of(quantities: Iterable[str]) -> Iterator[ReportCurve]:
    """A curve of each side, or of both, of every quantity that is asked for."""
    for text in dict.fromkeys(quantities):
        yield ReportCurve(text, dict.fromkeys(sides_of(asked_quantity(text)), text))


def _measure_group(
    tx: Transaction,
    read_body: Callable[[StoredDocument], Body],
    documents: Sequence[StoredDocument],
    asked: Sequence[AskedQuantity],
    source: EventSource,
) -> Group:
    units: dict[str, str] = {}
    trials = []
    for stored in documents:
        trials.append(measure_trial(tx, stored, read_body(stored), asked, source, units))
    return Group(tuple(trials), units)


def measure_trial(
    tx: Transaction,
    stored: StoredDocument,
    body: Body,
    asked: Sequence[AskedQuantity],
    source: EventSource,
    units: dict[str, str],
) -> Trial:
    """Measure the gait of a document, with cycles of quantities.

    body: of the document. units: of the quantities of earlier trials, which is extended; a quantity in another unit is
    left out. A trial that cannot be measured has the reason among its warnings.
    """
    try:
        seconds_of(stored)
        quantities = FrameQuantities(tx, stored, body)
        gait = quantities.measure_gait(source)
    except McmlError as error:
        return Trial(stored.uuid, stored.name, None, {}, (str(error),))
    cycles: dict[tuple[str, Side], Cycles] = {}
    warnings, lacking = list(gait.warnings), []
    for quantity in asked:
        try:
            values = quantity_columns(quantities, [quantity], 1, stored.frames)[:, 0]
            (unit,) = quantities.units([quantity])
        except McmlError:
            lacking.append(quantity.text)
            continue
        if units.setdefault(quantity.text, unit) != unit:
            warnings.append(f"{quantity.text} is in {unit or 'no unit'}, not in {units[quantity.text]}: left out")
            continue
        for side in sides_of(quantity):
            cycles[quantity.text, side] = gait.cycles(values, side)[0]
    if lacking:
        more = f" and {len(lacking) - _NAMED} more" if len(lacking) > _NAMED else ""
        warnings.append(f"it lacks {', '.join(lacking[:_NAMED])}{more}")
    return Trial(stored.uuid, stored.name, gait, cycles, tuple(warnings))


def rows_of(comparison: Comparison) -> Iterator[tuple[Any, ...]]:
    """Parameters of every stride, then every cycle, in long form with the values of COLUMNS.

    Strides of means alone, counted by side from 1; percent is None for parameters. A cycle has the number of its
    stride, although strides with a gap have none.
    """
    for name, group in comparison.groups.items():
        for trial in group.trials:
            about = (name, trial.document, trial.name)
            strides = () if trial.gait is None else trial.gait.strides
            numbered = {side: [each for each in strides if each.side == side and not each.rejected] for side in SIDES}
            for side, own in numbered.items():
                for number, stride in enumerate(own, 1):
                    for parameter in PARAMETERS:
                        value = getattr(stride, parameter.name)
                        yield (*about, parameter.name, "", parameter.unit, side, number, None, value)
            for (text, side), cycles in trial.cycles.items():
                quantity, axis = _name_and_axis(text)
                numbers = {(stride.begin, stride.end): number for number, stride in enumerate(numbered[side], 1)}
                for interval, curve in zip(cycles.intervals, cycles.curves.tolist(), strict=True):
                    for percent, value in enumerate(curve):
                        unit = group.units[text]
                        yield (*about, quantity, axis, unit, side, numbers[interval], percent, value)


def _name_and_axis(text: str) -> tuple[str, str]:
    """Of a quantity, as requests write it; the axis is "" where it has none."""
    asked = asked_quantity(text)
    axis = asked.arguments[-1] if asked.of_file and len(asked.arguments) > 1 else ""
    return (asked.arguments[0] if asked.name == "quantity" else text.removesuffix(f",{axis}")), axis


def describe_comparison(comparison: Comparison) -> wire.GaitComparison:
    """Describe a comparison, without the curves of single strides."""
    groups = {name: _describe_group(group, comparison.curves) for name, group in comparison.groups.items()}
    return wire.GaitComparison(
        curves=[
            wire.GaitCurve(
                title=curve.title,
                left=curve.quantities.get("left", ""),
                right=curve.quantities.get("right", ""),
                positive=curve.positive,
                negative=curve.negative,
            )
            for curve in comparison.curves
        ],
        **groups,
    )


def _describe_group(group: Group, curves: Iterable[ReportCurve]) -> wire.GaitGroup:
    cycles = []
    for side, quantity in dict.fromkeys(pair for curve in curves for pair in curve.quantities.items()):
        mean, (_, gaps) = group.mean(quantity, side), group.cycles(quantity, side)
        cycles.append(
            wire.GaitCycle(
                quantity=quantity,
                unit=group.units.get(quantity, ""),
                side=side,
                n=mean.n,
                gaps=gaps,
                mean=list(map(value_or_none, mean.mean.tolist())),
                sd=list(map(value_or_none, mean.sd.tolist())),
            )
        )
    return wire.GaitGroup(
        trials=[_describe_trial(trial) for trial in group.trials],
        parameters=[
            wire.GaitParameter(
                name=parameter.name,
                unit=parameter.unit,
                how=parameter.how,
                left=summary_of(left),
                right=summary_of(right),
                symmetry=value_or_none(symmetry(left.mean, right.mean)),
            )
            for parameter in PARAMETERS
            for left, right in [[group.summary(side, parameter.name) for side in SIDES]]
        ],
        cycles=cycles,
    )


def _describe_trial(trial: Trial) -> wire.GaitTrial:
    gait = trial.gait
    strides = [] if gait is None else [stride.side for stride in gait.strides if not stride.rejected]
    return wire.GaitTrial(
        id=trial.document,
        name=trial.name,
        measured=gait is not None,
        strides={side: strides.count(side) for side in SIDES},
        event_sources=[] if gait is None else sorted({event.source for event in gait.events}),
        warnings=list(trial.warnings),
    )
