"""How a query runs, in words."""

from __future__ import annotations

from collections.abc import Sequence

from mcml.language.addresses import address_attribute
from mcml.motion.skeleton import CHANNELS
from mcml_service.xpath.engine.column_source import ColumnSource
from mcml_service.xpath.engine.scan import Scan
from mcml_service.xpath.engine.starts import NUMBER
from mcml_service.xpath.language.conditions import Sample
from mcml_service.xpath.language.motion_functions import OF_FRAME_SETS, WINDOW
from mcml_service.xpath.language.tree import Call
from mcml_service.xpath.language.unparse import unparse


def steps_of(source: Scan | ColumnSource) -> list[str]:
    """Describe the steps of a source."""
    return _scan(source) if isinstance(source, Scan) else _columns(source)


def body_steps(calls: Sequence[Call], documents: int) -> list[str]:
    """Describe the use of bodies in motion.

    calls: of their functions. documents: number of documents with loaded facts of bodies.
    """
    columns = list(dict.fromkeys(unparse(call) for call in calls if call.function not in OF_FRAME_SETS))
    found = []
    if columns:
        found.append(f"columns of {', '.join(columns)}: a number for every frame of {documents:,} documents")
    windows = dict.fromkeys(unparse(call) for call in calls if call.function == WINDOW)
    return found + [f"{window} of all frames together" for window in windows]


def _scan(source: Scan) -> list[str]:
    plan = source.plan
    steps = [f"spans named {_names(group)}, by the index on names" for group in plan.names]
    bones = f"the bone {plan.lead!r}" if plan.lead is not None else "all bones"
    zones = [f"{_sample(sample)} {operator} {bound:g}" for sample, operator, bound in plan.condition.bounds]
    steps.append(f"tracks of {bones} whose zone maps allow {' and '.join(zones) or 'the condition'}")
    samples = ", ".join(sorted(_sample(sample) for sample in plan.condition.samples))
    steps.append(f"where they do not decide it, the condition on {samples}, a track of 256 frames at a time")
    if plan.target != "frame":
        steps.append("their frame_bones" + (f" named {plan.bone!r}" if plan.bone is not None else ""))
    if plan.attribute is not None:
        steps.append(f"their attribute {plan.attribute}")
    return steps


def _columns(source: ColumnSource) -> list[str]:
    start = source.start
    if start is None:
        return [f"on columns: {unparse(source.tree)}"]
    steps = [f"spans named {_names(group)}, by the index on names" for group in start.groups]
    if start.numbers is not None:
        name, way = ("@id", "runs of ids") if start.numbers.by_id else ("position()", "positions")
        asked = unparse(start.numbers.condition).replace(unparse(NUMBER), name)
        steps.append(f"frames with {asked}, by arithmetic on {way}")
    if not start.indexed:
        steps.append("all frames, by the timeline")
    steps += [f"of these, those where {unparse(predicate)}" for predicate in start.predicates]
    if start.steps:
        steps.append("from these, on columns: " + "/".join(unparse(step) for step in start.steps))
    return steps


def _names(group: tuple[str, ...]) -> str:
    return " or ".join(repr(name) for name in group)


def _sample(sample: Sample) -> str:
    channel = CHANNELS[sample.channel]
    return address_attribute(sample.bone, channel) if sample.bone is not None else f"@{channel}"
