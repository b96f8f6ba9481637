"""Stored motions on the skeleton of another document, as new documents."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from schemas.retarget import (
    BoneError,
    FootSliding,
    JointMatch,
    Retargeted,
    RetargetedOne,
    Retargeting,
    RetargetMany,
    RetargetRequest,
)
from service.actions.checking.describe_problem import problem_of
from service.actions.composing.fit_skeleton import JointMapping, are_markers, match_joints, upright, with_body
from service.actions.composing.keep_mapping import mapping_of
from service.actions.composing.select_documents import select_documents
from service.actions.editing.reshape_motion import Whole, read_whole
from service.actions.importing.store_clip import store_stream
from service.actions.reading.edit_header import seconds_of
from service.errors import DocumentError, McmlError
from service.motion.clip import ClipStream
from service.motion.retarget import Retargeted as Result
from service.motion.retarget import retarget
from service.motion.skeleton import Skeleton
from service.settings import Settings
from service.storage.database import Database, Transaction
from service.storage.documents import StoredDocument
from service.xpath.run import Queries

_Stored: TypeAlias = tuple[StoredDocument, Whole]


def retarget_motion(
    database: Database, settings: Settings, uuid: str, request: RetargetRequest, author: str
) -> Retargeted:
    """Bring a motion onto another skeleton.

    Raises DocumentError for markers and for names that are not there, ConversionError where no joints match.
    """
    with database.read() as tx:
        motion, body, mapping = _read(tx, uuid, request)
    return _retarget(database, settings, motion, body, mapping, request, request.name, author)


def retargeted_clip(database: Database, uuid: str, request: RetargetRequest) -> ClipStream:
    """The clip that a request makes, in memory."""
    with database.read() as tx:
        motion, body, mapping = _read(tx, uuid, request)
    return _fitted(motion, body, mapping, request).stream


def _read(tx: Transaction, uuid: str, request: RetargetRequest) -> tuple[_Stored, _Stored, JointMapping | None]:
    stored, other = tx.documents.get(uuid), tx.documents.get(request.skeleton)
    mapping = mapping_of(tx, request.project or stored.project, request.mapping)
    return (stored, read_whole(tx, stored)), (other, read_whole(tx, other, 1, 1)), mapping


def retarget_many(
    database: Database, queries: Queries, settings: Settings, request: RetargetMany, author: str
) -> Iterator[RetargetedOne]:
    """Bring the motions of all selected documents onto another skeleton, one after the other; each is done or says why
    not. What fails for all, as a selection of nothing or a mapping that is not there, is raised before the first."""
    selected, _ = select_documents(database, queries, request.selection)
    with database.read() as tx:
        other = tx.documents.get(request.skeleton)
        target = read_whole(tx, other, 1, 1)
        if isinstance(request.mapping, str) and request.project is not None:
            mapping_of(tx, request.project, request.mapping)
    if are_markers(target.head.skeleton):
        raise DocumentError("Markers have no skeleton.", remedy="Choose a document of a body.")
    return _each(database, settings, [str(item["document"]) for item in selected], (other, target), request, author)


def _each(
    database: Database,
    settings: Settings,
    documents: list[str],
    body: _Stored,
    request: RetargetMany,
    author: str,
) -> Iterator[RetargetedOne]:
    for uuid in documents:
        if uuid == body[0].uuid:
            continue
        name = ""
        try:
            with database.read() as tx:
                stored = tx.documents.get(uuid)
                name = stored.name
                source = read_whole(tx, stored)
                mapping = mapping_of(tx, request.project or stored.project, request.mapping)
            made = _retarget(database, settings, (stored, source), body, mapping, request, None, author)
            yield RetargetedOne(source=uuid, name=name, made=made)
        except McmlError as error:
            yield RetargetedOne(source=uuid, name=name, problem=problem_of(error))


@dataclass(frozen=True)
class _Fitted:
    """A motion on another body, before anything is stored."""

    stream: ClipStream
    made: Result
    skeletons: tuple[Skeleton, Skeleton]
    notices: list[str]


def _fitted(motion: _Stored, body: _Stored, mapping: JointMapping | None, request: Retargeting) -> _Fitted:
    (stored, source), (_, target) = motion, body
    seconds = seconds_of(stored)
    if are_markers(source.head.skeleton) or are_markers(target.head.skeleton):
        raise DocumentError("Markers have no skeleton.", remedy="Choose a document of a body.")
    source, notices = upright(source, target.up)
    one, two = source.head.skeleton, target.head.skeleton
    made = retarget(
        one,
        source.block,
        two,
        match_joints(one, two, mapping),
        seconds,
        reading=source.reading,
        target_reading=target.reading,
        clean=request.clean_feet,
        up=target.up,
    )
    head = replace(with_body(source.head, target.head), frame_time=stored.frame_time)
    block = made.block
    return _Fitted(ClipStream(head, lambda: iter([block]), len(block)), made, (one, two), notices)


def _retarget(
    database: Database,
    settings: Settings,
    motion: _Stored,
    body: _Stored,
    mapping: JointMapping | None,
    request: Retargeting,
    name: str | None,
    author: str,
) -> Retargeted:
    fitted = _fitted(motion, body, mapping, request)
    document = None
    if not request.preview:
        sources = [{"document": stored.uuid, "revision": stored.revision} for stored, _ in (motion, body)]
        document = store_stream(
            database,
            fitted.stream,
            settings,
            name=name or motion[0].name,
            project=request.project or motion[0].project,
            author=author,
            provenance={"analysis": "retarget", "sources": sources, "parameters": _parameters(request, mapping)},
        )
    return _told(document, fitted.made, *fitted.skeletons, fitted.notices)


def _parameters(request: Retargeting, mapping: JointMapping | None) -> dict[str, Any]:
    """As asked; a saved mapping by its pairs too, for it may be changed later."""
    asked = request.model_dump(mode="json", exclude_defaults=True, exclude={"selection"})
    if isinstance(request.mapping, str) and mapping is not None:
        asked["pairs"] = [pair.model_dump() for pair in mapping.pairs]
    return asked


def _told(document: str | None, made: Result, source: Skeleton, target: Skeleton, notices: list[str]) -> Retargeted:
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
        notices=notices
        + [notice.what for notice in [*report.notices(source, target), *made.shortfall.notices(target)]],
    )
