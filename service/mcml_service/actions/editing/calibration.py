"""The calibration of a document as people see and set it.

The unit and the up axis are the header's own elements, all else properties (`mcml.motion.calibration_properties`): so
a calibration has revisions, and goes wherever the MCML goes.
"""

from __future__ import annotations

from typing import Any

import orjson

from mcml.errors import RequestError
from mcml.language.elements import to_head
from mcml.motion.bodies.calibration import Calibration
from mcml.motion.bodies.positions import filled
from mcml.motion.bodies.reference import pose_in
from mcml.motion.bodies.stature import Stature, find_stature
from mcml.motion.calibration_properties import OVERRIDES
from mcml.motion.clip import ReferencePose
from mcml.motion.units import reading_of
from mcml_schemas import bodies as wire
from mcml_service.actions.editing.whole_document import change_document
from mcml_service.clips.bodies import Body, read_bodies
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

LENGTHS = ("floor", "leg")
POSE = OVERRIDES + "pose"
"""The property that keeps the pose of a reference frame that was set."""


def describe_calibration(tx: Transaction, stored: StoredDocument) -> wire.Calibration:
    """Describe the calibration of the clip, with origins."""
    kept = Body.restore(stored_body) if (stored_body := tx.bodies.of([stored]).get(stored.key)) is not None else None
    (listed,) = tx.columns.documents([stored.key])
    body = kept or read_bodies(tx, [listed])[stored.key]
    head = to_head(tx.heads.document(stored), stored.frame_time)
    return _view(body, find_stature(head.skeleton, reading_of(head), body.calibration), kept=kept is not None)


def _view(body: Body, stature: Stature | None, *, kept: bool) -> wire.Calibration:
    known = body.calibration
    unit = known.origins["metres"].reason if known.origins["metres"].kind == "stated" else None
    values: dict[str, Any] = {
        "unit": (unit or known.metres, known.metres, "metres"),
        "up": (known.up, None, "up"),
        "reference": (_describe_pose_frame(known), None, "reference"),
        "leaps": (known.leaps, None, "leaps"),
    }
    for name in LENGTHS:
        length = getattr(known, name)
        values[name] = length, None if None in (length, known.metres) else length * known.metres, name
    shown = {
        name: wire.CalibrationValue(
            value=value, metres=metres, origin=known.origins[source].kind, reason=known.origins[source].reason
        )
        for name, (value, metres, source) in values.items()
    }
    height = wire.CalibrationValue(value=None, origin="unknown")
    if stature is not None:
        metres = None if known.metres is None else stature.height * known.metres
        height = wire.CalibrationValue(value=stature.height, metres=metres, origin=stature.kind, reason=stature.reason)
    return wire.Calibration(**shown, height=height, step=known.step, kept=kept)


def _describe_pose_frame(known: Calibration) -> str | int | None:
    """The frame, from 1, that the reference pose was found in, or "rest"."""
    if known.origins["reference"].kind == "unknown":
        return None
    return "rest" if known.reference is None else known.reference + 1


def change_calibration(tx: Transaction, stored: StoredDocument, change: wire.CalibrationChange) -> StoredDocument:
    """Set values, or take them back, as one revision. RequestError for a frame that the document does not have."""
    asked = change.model_dump(exclude_unset=True)
    if not asked:
        return stored
    facts = {name: asked[name] or "" for name in ("unit", "up") if name in asked}
    reference = asked.get("reference")
    if reference not in (None, "rest") and not 1 <= int(reference) <= stored.frames:
        raise RequestError(
            f"{stored.name!r} has no frame {reference}.", remedy=f"Its frames are 1 to {stored.frames}, or say rest."
        )
    own = {OVERRIDES + name: asked[name] for name in ("floor", "leg", "reference", "leaps") if name in asked}
    held = to_head(tx.heads.document(stored), stored.frame_time).properties
    gone = {*own, POSE} if OVERRIDES + "reference" in own else set(own)
    properties = [item for item in held if item[0] not in gone]
    for key, value in own.items():
        if key == OVERRIDES + "reference" and value is not None:
            properties.append((key, "null" if value == "rest" else str(int(value) - 1), ""))
            if value != "rest":
                # The clip may be cut later: the current pose of the frame stays the reference.
                properties.append((POSE, orjson.dumps(_pose(tx, stored, int(value)).to_json()).decode(), ""))
        elif value is not None:
            properties.append((key, orjson.dumps(value).decode(), ""))
    message = f"calibration: {', '.join(asked)}"
    return change_document(tx, stored, properties=properties if own else None, message=message, **facts)


def _pose(tx: Transaction, stored: StoredDocument, frame: int) -> ReferencePose:
    """The pose of a frame, from 1."""
    clip = read_clip(tx, stored, last=frame, bare=True).clip
    skeleton = clip.head.skeleton
    return pose_in(skeleton, reading_of(clip.head), filled(skeleton, clip.blocks()).values[-1])
