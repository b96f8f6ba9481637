"""How answers look on a terminal: a function for each model, by the name of the model; tables for all that list."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel
from rich.text import Text

from mcml_service.cli.terminal.opening import console, print_json, table
from mcml_service.cli.terminal.results import fail_with, show_job, show_result
from mcml_service.operations.operation import Effect, Operation

if TYPE_CHECKING:
    # A command makes the models of its own answer, and no others.
    from mcml_schemas.bodies import Calibration, CalibrationValue
    from mcml_schemas.documents import ChangedDocuments, DocumentDetail
    from mcml_schemas.elements import ElementEdited
    from mcml_schemas.frames import CurveSamples, FramesEdited
    from mcml_schemas.gait import CalibratedTrials, GaitComparison, GaitMeasures, StandingTrial
    from mcml_schemas.names import AliasTable
    from mcml_schemas.querying.saved import Vocabulary
    from mcml_schemas.retarget import Mapping
    from mcml_schemas.revisions import Difference, FrameRange

COLUMNS: dict[str, dict[str, str]] = {
    "DocumentPage": {
        "id": "id",
        "name": "name",
        "project": "project",
        "format": "format",
        "frames": "frames#,",
        "duration": "seconds#.2f",
    },
    "RevisionPage": {
        "number": "revision#",
        "time": "time",
        "author": "author",
        "operation": "what",
        "message": "why",
    },
    "LabelPage": {"id": "id#", "first": "first#", "last": "last#", "name": "name"},
    "SuggestedLabels": {
        "name": "name",
        "first": "first#",
        "last": "last#",
        "degrees": "degrees#.0f",
        "steps": "steps#",
        "confidence": "confidence#.2f",
    },
    "MappingPage": {
        "project": "project",
        "name": "name",
        "pairs": "joints#len",
        "version": "version#",
        "author": "author",
        "changed": "changed",
    },
    "JobPage": {
        "id": "id",
        "state": "state",
        "share": "done#.0%",
        "analysis": "analysis",
        "name": "name",
        "stage": "stage",
        "created": "created",
    },
    "ResultPage": {
        "id": "id",
        "analysis": "analysis",
        "name": "name",
        "project": "project",
        "inputs": "clips#len",
        "created": "created",
    },
}
"""Fields that lists show, with the headings of their columns: `#` is a number, behind it how it is written."""


def present(operation: Operation, answer: Any, as_json: bool = False) -> None:
    """Print an answer: as JSON for scripts, or for people."""
    if answer is None:
        return
    writes, kind = operation.effect is Effect.WRITES, type(answer).__name__
    if as_json:
        print_json(answer)
    elif kind == "DocumentDetail" and writes:
        _print_revision(answer)
    elif kind == "Job" and writes:
        console.print(f"{answer.state if answer.state != 'running' else 'ending'}  {answer.name}  {answer.id}")
    else:
        SHOW.get(kind, _anything)(answer)
    if kind == "Job" and not writes:
        fail_with(answer)


def print_items(answer: Any) -> None:
    """Items as a table."""
    columns = COLUMNS.get(type(answer).__name__) or _columns(answer)
    rows = table(*(heading.partition("#")[0] + ("#" if "#" in heading else "") for heading in columns.values()))
    for item in answer.items:
        rows.add_row(*(_cell(getattr(item, name), heading) for name, heading in columns.items()))
    console.print(rows)
    if type(answer).__name__ == "DocumentPage":
        console.print(f"{len(answer.items)} of {answer.total} documents", style="dim")


def _columns(answer: Any) -> dict[str, str]:
    """Return all plain fields of the listed items."""
    first = next(iter(answer.items), None)
    if not isinstance(first, BaseModel):
        return {}
    kinds = {name: type(getattr(first, name)) for name in type(first).model_fields}
    return {name: f"{name}#" if kind in (int, float) else name for name, kind in kinds.items() if kind in PLAIN}


PLAIN = (str, int, float, bool, type(None))


def _cell(value: Any, heading: str) -> str:
    form = heading.partition("#")[2]
    if form == "len":
        return str(len(value))
    return "" if value is None else format(value, form)


def _anything(answer: Any) -> None:
    if not hasattr(answer, "items"):
        for name, value in answer.model_dump(exclude_none=True).items():
            console.print(f"{name}  {value}")
    elif answer.items and isinstance(answer.items[0], str):
        for item in answer.items:
            console.print(item)
    else:
        print_items(answer)


def _print_revision(made: DocumentDetail) -> None:
    console.print(f"revision {made.revision}, {made.frames:,} frames")


def _document(found: DocumentDetail) -> None:
    rate = f"{1 / found.seconds_per_frame:.6g} Hz" if found.seconds_per_frame else "rate unknown"
    console.print(Text.assemble((found.name, "bold"), f"  {found.id}  revision {found.revision}"))
    console.print(
        f"{found.format}, {found.frames:,} frames, {rate}, unit {found.unit or 'unknown'}, up {found.up or 'unknown'}"
    )
    for fact in found.properties:
        console.print(f"  {fact.name} = {fact.value} {fact.unit}")
    rows = table("bone", "source name", "parent", "channels")
    for bone in found.bones:
        rows.add_row(bone.name, bone.source_name, bone.parent or "", " ".join(bone.channels))
    console.print(rows)
    for item in found.labels:
        console.print(f"  {item.first}-{item.last}  {item.name}")


def _print_changed(changed: ChangedDocuments) -> None:
    for item in changed.items:
        console.print(f"changed  {item.name}  {item.id}  revision {item.revision}")
    console.print(f"{len(changed.items)} changed")


def _element(done: ElementEdited) -> None:
    console.print(f"revision {done.revision}, {done.elements:,} edited")


def _frames(done: FramesEdited) -> None:
    console.print(f"revision {done.revision}, {done.frames:,} frames")
    for note in done.notes:
        console.print(f"  {note}", markup=False)
    if done.curves:
        rows = table("curve", "unit", "before#", "after#")
        for curve in done.curves:
            rows.add_row(curve.name, curve.unit, _extent(curve.before), _extent(curve.after))
        console.print(rows)


def _extent(curve: CurveSamples) -> str:
    """The least and the greatest sample."""
    low = min((value for value in curve.minimum if value is not None), default=None)
    high = max((value for value in curve.maximum if value is not None), default=None)
    return "" if low is None or high is None else f"{low:.6g} to {high:.6g}"


def _difference(found: Difference) -> None:
    def span(frames: FrameRange) -> str:
        return f"{frames.first}-{frames.last}"

    for element in found.elements:
        for sign, text in (("-", element.before), ("+", element.after)):
            if text is not None:
                console.print(f"{sign} {element.address}  {text}")
    if found.frames_before != found.frames_after or found.frames_moved:
        console.print(f"frames {found.frames_before:,} -> {found.frames_after:,}")
    for sign, ranges in (("-", found.frames_removed), ("+", found.frames_added)):
        for item in ranges:
            console.print(f"{sign} frames {span(item)}")
    for sign, labels in (("-", found.labels_removed), ("+", found.labels_added)):
        for label in labels:
            console.print(f"{sign} {label.first}-{label.last}  {label.name}")
    for bone in found.bones:
        channels = ", ".join(f"{name} by {value:.6g}" for name, value in bone.channels.items())
        angle = "" if bone.angle is None else f"; {bone.angle:.6g} degrees"
        console.print(f"~ {bone.bone}  {bone.first}-{bone.last}, {bone.frames:,} frames: {channels}{angle}")


def _mapping(mapping: Mapping) -> None:
    console.print(f"{mapping.name}  version {mapping.version}  {len(mapping.pairs)} joints")
    for pair in mapping.pairs:
        console.print(f"  {pair.source} -> {pair.target}")


def _aliases(made: AliasTable) -> None:
    rows = table("name in files", "joint")
    for item in made.items:
        rows.add_row(item.source, item.name)
    console.print(rows)
    console.print(f"project {made.project}, version {made.version}")


def _vocabulary(found: Vocabulary) -> None:
    rows = table("motion name", "colour#", "description")
    for item in found.items:
        rows.add_row(item.name, "" if item.colour is None else str(item.colour), item.description)
    console.print(rows)
    console.print(f"project {found.project}, version {found.version}")


def _calibration(found: Calibration) -> None:
    rows = table("what", "value", "metres#", "origin", "reason")
    for name in ("unit", "up", "floor", "leg", "reference", "leaps"):
        measured: CalibrationValue = getattr(found, name)
        value = (
            f"{measured.value:g}"
            if isinstance(measured.value, float)
            else ""
            if measured.value is None
            else str(measured.value)
        )
        rows.add_row(
            name, value, "" if measured.metres is None else f"{measured.metres:.4g}", measured.origin, measured.reason
        )
    console.print(rows)
    console.print(f"positions in steps of {found.step:g}" + ("" if found.kept else ", not kept yet: mcml db derive"))


def _gait(found: GaitMeasures) -> None:
    kinds = {True: "running", False: "walking", None: "gait unknown"}
    where = f"on a belt of {found.belt.speed:.3f} m/s" if found.belt.is_belt else "on the ground"
    sources = ", ".join(sorted({event.source for event in found.events})) or "none"
    console.print(f"{kinds[found.running]} {where}, {found.frame_rate:g} Hz, {len(found.events)} events from {sources}")
    rows = table("parameter", "unit", "left#", "sd#", "n#", "right#", "sd#", "n#", "symmetry %#")
    for item in found.parameters:
        sides = [
            text
            for side in (item.left, item.right)
            for text in (_decimal(side.mean, 3), _decimal(side.sd, 3), str(side.n))
        ]
        rows.add_row(item.name.replace("_", " "), item.unit, *sides, _decimal(item.symmetry, 1))
    console.print(rows)
    events = table("time (s)#", "frame#", "side", "event", "source", "within (s)#")
    for event in found.events:
        within = _decimal(event.within, 3)
        events.add_row(f"{event.time:.3f}", str(event.frame), event.side, event.kind, event.source, within)
    console.print(events)
    for cycle in found.cycles:
        known = [value for value in cycle.mean if value is not None]
        span = f"{min(known):.4g} to {max(known):.4g} {cycle.unit}" if known else "unknown"
        console.print(f"{cycle.quantity}  {cycle.side}  {cycle.n} cycles, mean {span}")
    for warning in found.warnings:
        console.print(f"warning: {warning}")


def _comparison(found: GaitComparison) -> None:
    groups = {"own": found.own, "compare": found.compare, "reference": found.reference}
    named = {name: group for name, group in groups.items() if group is not None}
    for name, group in named.items():
        for trial in group.trials:
            strides = f"{trial.strides['left']} left, {trial.strides['right']} right strides"
            console.print(f"{name}: {trial.name}, {strides if trial.measured else 'not measured'}")
    rows = table("parameter", "unit", *(f"{name} {side}#" for name in named for side in ("left", "right")))
    for place, item in enumerate(found.own.parameters):
        cells = []
        for group in named.values():
            for side in (group.parameters[place].left, group.parameters[place].right):
                spread = f" ± {_decimal(side.sd, 3)}" if side.sd is not None else ""
                cells.append(f"{_decimal(side.mean, 3)}{spread}")
        rows.add_row(item.name.replace("_", " "), item.unit, *cells)
    console.print(rows)
    for name, group in named.items():
        for cycle in group.cycles:
            known = [value for value in cycle.mean if value is not None]
            if known:
                span = f"{min(known):.4g} to {max(known):.4g} {cycle.unit}"
                console.print(f"{name}: {cycle.quantity}  {cycle.side}  {cycle.n} cycles, mean {span}")
    for trial in (trial for group in named.values() for trial in group.trials):
        for warning in trial.warnings:
            console.print(f"warning: {trial.name}: {warning}")


def _standing(found: StandingTrial) -> None:
    rows = table("measure", "value#", "unit", "source")
    for item in found.measures:
        rows.add_row(item.name, f"{item.value:.5g}", item.unit, item.source)
    console.print(rows)
    if found.virtual:
        markers = table("virtual marker", "carried by")
        for marker in found.virtual:
            markers.add_row(marker.name, ", ".join(marker.carriers))
        console.print(markers)
    for note in found.notes:
        console.print(f"note: {note}")


def _standing_use(found: CalibratedTrials) -> None:
    rows = table("id", "name", "revision#", "properties#")
    for item in found.items:
        rows.add_row(item.id, item.name, str(item.revision), str(len(item.measures)))
    console.print(rows)
    for item in found.items:
        for note in item.notes:
            console.print(f"note: {item.name}: {note}")


def _decimal(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"


SHOW: dict[str, Callable[[Any], None]] = {
    "DocumentDetail": _document,
    "ChangedDocuments": _print_changed,
    "ElementEdited": _element,
    "FramesEdited": _frames,
    "Difference": _difference,
    "Mapping": _mapping,
    "AliasTable": _aliases,
    "Vocabulary": _vocabulary,
    "Calibration": _calibration,
    "GaitMeasures": _gait,
    "GaitComparison": _comparison,
    "StandingTrial": _standing,
    "CalibratedTrials": _standing_use,
    "Job": show_job,
    "Result": show_result,
}
"""Models that are more than lists, and how each is shown."""
