"""A stored motion on the skeleton of another document, as a new document."""

from __future__ import annotations

from dataclasses import replace

from schemas.retarget import BoneError, FootSliding, JointMatch, Retargeted, RetargetRequest
from service.actions.reshape_motion import Whole, read_whole
from service.actions.store_clip import store_stream
from service.errors import DocumentError
from service.motion.bone_mapping import Match, suggest_matches
from service.motion.clip import ClipHead, ClipStream
from service.motion.retarget import Retargeted as Result
from service.motion.retarget import retarget
from service.motion.skeleton import Convention, Skeleton
from service.settings import Settings
from service.storage.database import Database
from service.storage.documents import StoredDocument

_OF_SKELETON = ("skeleton_name", "calibration_unit", "global_axis_of_gravity", "bone_length_axis", "units_angle")
"""Fields of a header that belong to the skeleton's own numbers."""


def retarget_motion(
    database: Database, settings: Settings, uuid: str, request: RetargetRequest, author: str
) -> Retargeted:
    """Bring a motion onto another skeleton.

    Raises DocumentError for markers, axes that differ, and names that are not there.
    """
    with database.read() as tx:
        stored, other = tx.documents.get(uuid), tx.documents.get(request.skeleton)
        source, target = read_whole(tx, stored), read_whole(tx, other, 1, 1)
    seconds = stored.seconds_per_frame
    if seconds is None:
        raise DocumentError("The document has no frame time.", remedy="State it: PATCH the document with frame_time.")
    _check(source, target)
    one, two = source.head.skeleton, target.head.skeleton
    made = retarget(
        one,
        source.block,
        two,
        _matches(one, two, request),
        seconds,
        reading=source.reading,
        target_reading=target.reading,
        clean=request.clean_feet,
        up=source.up,
    )
    document = None
    if not request.preview:
        block = made.block
        document = store_stream(
            database,
            ClipStream(_head(source.head, target.head, stored), lambda: iter([block]), len(block)),
            settings,
            name=request.name or stored.name,
            project=request.project or stored.project,
            author=author,
            provenance={
                "analysis": "retarget",
                "sources": [
                    {"document": stored.uuid, "revision": stored.revision},
                    {"document": other.uuid, "revision": other.revision},
                ],
                "parameters": request.model_dump(mode="json", exclude_defaults=True),
            },
        )
    return _told(document, made, one, two)


def _check(source: Whole, target: Whole) -> None:
    for whole in (source, target):
        if any(joint.convention is Convention.MARKER for joint in whole.head.skeleton.joints):
            raise DocumentError("Markers have no skeleton.", remedy="Choose a document of a body.")
    if source.up != target.up:
        raise DocumentError(
            f"{source.up} points up in the motion, {target.up} in the skeleton.",
            remedy="Export one with up=, and import it.",
        )


def _matches(source: Skeleton, target: Skeleton, request: RetargetRequest) -> tuple[Match, ...]:
    if request.mapping is None:
        return suggest_matches(source, target)
    suggested = {(match.source, match.target): match for match in suggest_matches(source, target)}
    found = []
    for pair in request.mapping:
        for name, skeleton, what in ((pair.source, source, "motion"), (pair.target, target, "skeleton")):
            if name not in skeleton.names:
                raise DocumentError(f"The {what} has no joint {name!r}.", remedy="Ask with preview for all names.")
        key = source.names.index(pair.source), target.names.index(pair.target)
        found.append(suggested.get(key) or Match(*key, 1.0, "you said so"))
    return tuple(found)


def _head(source: ClipHead, target: ClipHead, stored: StoredDocument) -> ClipHead:
    """What is said of the motion, with the body of the other document."""
    fields = {
        name: text for name, text in source.fields.items() if name not in (*_OF_SKELETON, "num_frames", "num_segments")
    }
    fields |= {name: text for name, text in target.fields.items() if name in _OF_SKELETON}
    for name in ("units_mass", "units_length", "scale_factor", "euler_rotation_order"):
        fields.pop(name, None)
        if name in target.fields:
            fields[name] = target.fields[name]
    return replace(
        source,
        format=target.format,
        skeleton=target.skeleton,
        fields=fields,
        frame_time=stored.frame_time,
        sources=target.sources,
    )


def _told(document: str | None, made: Result, source: Skeleton, target: Skeleton) -> Retargeted:
    report = made.report
    return Retargeted(
        document=document,
        frames=len(made.block),
        scale=report.scale,
        matches=[
            JointMatch(
                source=source.names[match.source],
                target=target.names[match.target],
                confidence=match.confidence,
                reason=match.reason,
            )
            for match in report.matches
        ],
        unmatched_source=[source.names[index] for index in report.missing],
        unmatched_target=[target.names[index] for index in report.extra],
        bones=[
            BoneError(
                bone=target.names[bone.joint],
                end=target.names[bone.end],
                leads=bone.leads,
                mean=bone.mean,
                largest=bone.largest,
            )
            for bone in report.bones
        ],
        feet=[
            FootSliding(foot=target.names[foot.joint], stances=len(foot.contacts), before=foot.before, after=foot.after)
            for foot in report.feet
        ],
        notices=[notice.what for notice in [*report.notices(source, target), *made.shortfall.notices(target)]],
    )
