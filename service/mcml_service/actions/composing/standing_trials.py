"""Standing trials: their measures, and walking trials that take them as properties."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

from mcml.errors import DocumentError, RequestError
from mcml.formats.gait_properties import FOOT_OPTIONS, unit_of_measure
from mcml.formats.gait_quantities import GaitQuantities
from mcml.formats.measurements import Measurements
from mcml.laboratory.gait_model import standing_trial as standing
from mcml.language.elements import to_head
from mcml.motion.markers import read_marker_positions
from mcml.motion.skeleton import Array
from mcml_schemas import gait as wire
from mcml_service.actions.editing.whole_document import change_document
from mcml_service.clips.frame_quantities import read_measurements
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

MOST: Final = 1000
"""Walking trials of one request at most."""


def describe_standing(
    tx: Transaction, stored: StoredDocument, foot: wire.FootOption | None, subject: str | None
) -> wire.StandingTrial:
    """Describe the measures of a standing trial. DocumentError if it has none."""
    trial = _measure(tx, stored, foot, subject)
    measures = [
        wire.StandingMeasure(name=each.name, value=each.value, unit=unit_of_measure(each.name), source=each.source)
        for each in trial.measures
    ]
    virtual = [wire.VirtualMarker(name=name, carriers=list(each.places)) for name, each in trial.virtual.items()]
    return wire.StandingTrial(measures=measures, virtual=virtual, notes=list(trial.notes))


def use_standing(
    tx: Transaction, stored: StoredDocument, documents: Sequence[str], use: wire.StandingTrialUse
) -> list[wire.CalibratedTrial]:
    """Give the measures of a standing trial to walking trials, each as a revision.

    documents: their ids. DocumentError if the standing trial has no measures, or a trial no markers of a person.
    """
    if len(documents) > MOST:
        raise RequestError(f"{len(documents)} trials are selected; at most {MOST} are changed at once.",
                           remedy="Select fewer.")  # fmt: skip
    trial = _measure(tx, stored, use.foot, use.subject)
    items = []
    for uuid in documents:
        walking = tx.documents.get(uuid)
        tx.documents.lock(walking.key)
        measurements = read_measurements(tx, walking)
        gait = _gait_of(measurements, walking, use.subject)
        if not gait.has_pelvis:
            raise DocumentError(
                f"{walking.name!r} has no markers of a pelvis.",
                remedy="Select walking trials of markers alone.",
            )
        held = to_head(tx.heads.document(walking), walking.frame_time).properties
        properties, notes = gait.use_standing_trial(
            trial, stored.name, measurements.quantities, partial(_positions, tx, walking)
        )
        changed = [item[0] for item in properties if item not in held]
        if changed or len(properties) != len(held):
            walking = change_document(
                tx, walking, properties=properties, message=f"measures of the standing trial {stored.name}"
            )
        items.append(
            wire.CalibratedTrial(
                id=walking.uuid, name=walking.name, revision=walking.revision, measures=changed, notes=notes
            )
        )
    return items


def _measure(
    tx: Transaction, stored: StoredDocument, foot: wire.FootOption | None, subject: str | None
) -> standing.StandingTrial:
    option = None if foot is None else FOOT_OPTIONS[foot]
    trial = _gait_of(read_measurements(tx, stored), stored, subject).measure_standing(
        partial(_positions, tx, stored), option
    )
    if trial.lacks:
        raise DocumentError(f"{stored.name!r} is no standing trial: {trial.lacks}.", remedy=standing.STANDING_REMEDY)
    return trial


def _positions(tx: Transaction, stored: StoredDocument, joints: Sequence[int]) -> Array:
    return read_marker_positions(read_clip(tx, stored, labelled=False).clip, joints)


def _gait_of(measurements: Measurements, stored: StoredDocument, subject: str | None) -> GaitQuantities:
    people = measurements.gait
    if people.people and subject not in people.people:
        raise RequestError(
            f"{stored.name!r} has markers of several people.",
            remedy=f"Say whose with `subject`: {', '.join(people.people)}.",
        )
    return people.of(subject)
