"""Stored motions on the skeleton of another document, or on a known rig, as new documents."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mcml.errors import DocumentError, McmlError
from mcml.motion.clip import ClipStream
from mcml.motion.frames import joined
from mcml.motion.hub_writer import HubWriter
from mcml.motion.retargeting.known_rigs import KNOWN_RIGS
from mcml.motion.retargeting.limits import Limits, file_limits
from mcml.motion.retargeting.move_character import with_body
from mcml.motion.retargeting.report import RetargetReport
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.skeleton import Array
from mcml.motion.solving.marker_skeleton import has_markers
from mcml.motion.units import metres_of
from mcml_schemas.retarget import (
    Retargeted,
    RetargetedOne,
    Retargeting,
    RetargetMany,
    RetargetRequest,
)
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.checking.describe_problem import problem_of
from mcml_service.actions.composing.describe_retargeting import describe_retargeted
from mcml_service.actions.composing.fit_skeleton import JointMapping, give_skeleton, match_joints, upright
from mcml_service.actions.composing.keep_mapping import mapping_of
from mcml_service.actions.composing.select_documents import select_documents
from mcml_service.actions.editing.motion_processing import Whole, read_whole
from mcml_service.actions.importing.store_clip import store_stream
from mcml_service.actions.reading.preview_motion import Window, preview_motion
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.queries import Queries


@dataclass(frozen=True)
class _Target:
    """The body that motions are brought to. stored: its document, None for a known rig."""

    whole: Whole
    stored: StoredDocument | None


def retarget_motion(
    database: Database,
    settings: Settings,
    uuid: str,
    request: RetargetRequest,
    author: str,
    window: Window | None = None,
) -> Retargeted:
    """Retarget a motion to another skeleton or to a known rig.

    window: frames whose positions are returned. Raises DocumentError for markers and for unknown names, ConversionError
    if no joints match.
    """
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        target = _read_target(tx, request)
        source = read_whole(tx, stored)
        mapping = mapping_of(tx, request.project or stored.project, request.mapping)
    return _retarget(database, settings, (stored, source), target, mapping, request, request.name, author, window)


def retarget_many(
    database: Database, queries: Queries, settings: Settings, request: RetargetMany, author: str
) -> Iterator[RetargetedOne]:
    """Retarget the motions of all selected documents to another skeleton, one after the other; each gives a document
    or a problem. Errors for all, such as an empty selection or an unknown mapping, are raised before the first.
    """
    selected, _ = select_documents(database, queries, request.selection)
    with database.read() as tx:
        target = _read_target(tx, request)
        if isinstance(request.mapping, str) and request.project is not None:
            mapping_of(tx, request.project, request.mapping)
    return _each(database, settings, [str(item["document"]) for item in selected], target, request, author)


def _read_target(tx: Transaction, request: Retargeting) -> _Target:
    """Raises DocumentError for a document of markers, NotFoundError."""
    if request.to is not None:
        rig = KNOWN_RIGS[request.to]
        clip = rig.clip()
        return _Target(Whole(clip.head, joined(clip.blocks()), clip.head.skeleton.names, rig.up), None)
    stored = tx.documents.get(str(request.skeleton))
    whole = read_whole(tx, stored, 1, 1)
    if has_markers(whole.head.skeleton):
        raise DocumentError("Markers have no skeleton.", remedy="Choose a document of a body.")
    return _Target(whole, stored)


def _each(
    database: Database,
    settings: Settings,
    documents: list[str],
    target: _Target,
    request: RetargetMany,
    author: str,
) -> Iterator[RetargetedOne]:
    for uuid in documents:
        if target.stored is not None and uuid == target.stored.uuid:
            continue
        name = ""
        try:
            with database.read() as tx:
                stored = tx.documents.get(uuid)
                name = stored.name
                source = read_whole(tx, stored)
                mapping = mapping_of(tx, request.project or stored.project, request.mapping)
            made = _retarget(database, settings, (stored, source), target, mapping, request, None, author)
            yield RetargetedOne(source=uuid, name=name, made=made)
        except McmlError as error:
            yield RetargetedOne(source=uuid, name=name, problem=problem_of(error))


def _retarget(
    database: Database,
    settings: Settings,
    motion: tuple[StoredDocument, Whole],
    body: _Target,
    mapping: JointMapping | None,
    request: Retargeting,
    name: str | None,
    author: str,
    window: Window | None = None,
) -> Retargeted:
    (stored, source), target = motion, body.whole
    seconds = seconds_of(stored)
    source, notices = give_skeleton(source)
    source, turned = upright(source, target.up)
    notices += turned
    source_skeleton, two = source.head.skeleton, target.head.skeleton
    metres, target_metres = metres_of(source.head), metres_of(target.head)
    known = metres is not None and target_metres is not None
    units = metres / target_metres if metres is not None and target_metres is not None else 1.0
    if request.travel_scale is not None and not known:
        notices.append("the unit of length of a document is unknown: the travel scale is of numbers, not of metres")
    made = retarget(
        source_skeleton,
        source.block,
        two,
        match_joints(source_skeleton, two, mapping),
        seconds,
        reading=source.reading,
        target_reading=target.reading,
        clean=request.clean_feet,
        up=target.up,
        scale=request.scale,
        travel_scale=None if request.travel_scale is None else request.travel_scale * units,
        limits=_limits(request, target),
        keep_hands=request.keep_hands,
        match_rest=request.match_rest,
        target_block=target.block,
    )
    document = None
    if not request.preview:
        head = replace(with_body(source.head, target.head), frame_time=stored.frame_time)
        block = made.block
        document = store_stream(
            database,
            ClipStream(head, lambda: iter([block]), len(block)),
            settings,
            name=name or stored.name,
            project=request.project or stored.project,
            author=author,
            provenance={
                "analysis": "retarget",
                "sources": [
                    {"document": each.uuid, "revision": each.revision}
                    for each in (stored, body.stored)
                    if each is not None
                ],
                "parameters": _parameters(request, mapping),
            },
        )
    told = describe_retargeted(document, made, source_skeleton, two, notices)
    told.travel_scale = made.report.travel / units
    told.foot_slide = _foot_slide(made.report, seconds, target_metres)
    if window is not None:
        told.motion = preview_motion(with_body(source.head, target.head), [made.block], window, seconds)
    return told


def _parameters(request: Retargeting, mapping: JointMapping | None) -> dict[str, Any]:
    """Return the parameters of the request, with the pairs of a saved mapping, because it may be changed later."""
    asked = request.model_dump(mode="json", exclude_defaults=True, exclude={"selection"})
    if isinstance(request.mapping, str) and mapping is not None:
        asked["pairs"] = [pair.model_dump() for pair in mapping.pairs]
    return asked


def _limits(request: Retargeting, target: Whole) -> Limits | None:
    """Return the limits of joints of a request. DocumentError for a table with unknown joints or axes, and where the
    target's file states none.
    """
    if request.limits is None:
        return None
    skeleton = target.head.skeleton
    writer = HubWriter(skeleton, target.reading)
    if request.limits == "file":
        if found := file_limits(skeleton, writer):
            return found
        raise DocumentError("The target's file states no limits of joints.", remedy="Give a table of limits.")
    table: dict[int, Array] = {}
    for row in request.limits:
        (joint,) = target.joints([row.joint])
        letters = writer.letters(joint)
        if row.axis not in letters:
            raise DocumentError(
                f"Joint {row.joint!r} does not rotate about {row.axis}.",
                remedy=f"Its axes are {', '.join(letters) or 'none'}.",
            )
        limits = table.setdefault(joint, np.tile([-np.inf, np.inf], (len(letters), 1)))
        limits[letters.index(row.axis)] = row.low, row.high
    return table


def _foot_slide(report: RetargetReport, frame_time: float, metres: float | None) -> float | None:
    """Centimetres a second of the foot that slides most during its contacts."""
    times = [frame_time * sum(last - first for first, last in foot.contacts) for foot in report.feet]
    speeds = [foot.after / time for foot, time in zip(report.feet, times, strict=True) if time > 0]
    return None if metres is None or not speeds else 100 * metres * max(speeds)
