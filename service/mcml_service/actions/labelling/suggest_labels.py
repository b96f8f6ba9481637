"""Motion names for a document, from its motion."""

from __future__ import annotations

from mcml.errors import ConflictError, ConversionError, DocumentError
from mcml.language.motion_names import MotionName
from mcml.motion.anatomy.movement_names import suggest_movements
from mcml.motion.bodies.activities.recognition import find_unknown, recognize_activities
from mcml.motion.bodies.activities.signals import JOINTS
from mcml.motion.hub import HubReader
from mcml.motion.skeleton import Convention
from mcml_schemas.labels import SuggestedLabel
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.editing.motion_processing import read_whole
from mcml_service.actions.editing.whole_document import add_labels
from mcml_service.clips.bodies import read_bodies
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


def suggest_activities(
    tx: Transaction, stored: StoredDocument, confidence: float
) -> tuple[list[SuggestedLabel], list[str]]:
    """Return activities with at least this confidence, in order, and warnings of unrecognised ones."""
    (listed,) = tx.columns.documents([stored.key])
    stretch = read_bodies(tx, [listed])[stored.key].stretch(JOINTS)
    found = [
        SuggestedLabel(
            name=activity.name,
            first=activity.first + 1,
            last=activity.last + 1,
            degrees=activity.degrees,
            steps=activity.steps,
            confidence=activity.confidence,
        )
        for activity in recognize_activities(stretch)
        if activity.confidence >= confidence
    ]
    return found, find_unknown(stretch)


def suggest_movement_names(
    tx: Transaction, stored: StoredDocument, confidence: float, facing: str | None = None
) -> list[SuggestedLabel]:
    """Return anatomical movements with at least this confidence, in order.

    Nothing is written. facing: the axis along which the body faces when it is upright, for rigs without sides in their
    names. Raises DocumentError for markers and without a frame time, ConversionError if left and right are unknown.
    """
    seconds = seconds_of(stored)
    whole = read_whole(tx, stored)
    skeleton = whole.head.skeleton
    if any(joint.convention is Convention.MARKER for joint in skeleton.joints):
        raise DocumentError("Markers have no joint angles.", remedy="Choose a document of a body.")
    reader = HubReader(skeleton, whole.reading)
    hub = reader.read(whole.block)
    try:
        movements = suggest_movements(
            skeleton, reader.rest, hub.translations, hub.rotations, seconds, whole.up, facing=facing
        )
    except ConversionError as error:
        error.remedy = "Say where the body faces, across the axis up: `facing` (`--facing` of the command), Z or -X …"
        raise
    return [
        SuggestedLabel(
            name=str(MotionName(movement.side, movement.part, movement.movement)),
            first=movement.first + 1,
            last=movement.last + 1,
            degrees=movement.degrees,
            confidence=movement.confidence,
        )
        for movement in movements
        if movement.confidence >= confidence
    ]


def accept_movement_names(database: Database, uuid: str, confidence: float, author: str) -> int:
    """Name frames as suggested, as one revision; answers how many labels were added. Raises as
    `suggest_movement_names`."""
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        suggestions = suggest_movement_names(tx, stored, confidence)
    with database.write(author) as tx:
        tx.documents.lock(stored.key)
        current = tx.documents.get(uuid)
        if current.revision != stored.revision:
            raise ConflictError(f"{stored.name} was edited meanwhile.", remedy="Repeat the request.")
        return len(add_labels(tx, current, [(item.name, item.first, item.last) for item in suggestions], strict=True))
