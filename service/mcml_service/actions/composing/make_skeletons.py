"""Skeletons for the people of a stored marker trial, each as a new document."""

from __future__ import annotations

import math

from mcml.errors import ConversionError, NotFoundError
from mcml.motion.solving.marker_skeleton import Miss, SolvedPerson, has_markers, solve_people
from mcml.motion.units import metres_of
from mcml_schemas.compose import JointMiss, MadeSkeleton, MadeSkeletons, SkeletonsRequest
from mcml_service.actions.editing.motion_processing import read_whole
from mcml_service.actions.importing.store_clip import store_stream
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument


def make_skeletons(
    database: Database, settings: Settings, uuid: str, request: SkeletonsRequest, author: str
) -> MadeSkeletons:
    """Store a document with a skeleton for every person of a marker trial.

    Raises ConversionError for a document of a body and for markers that show no skeleton, NotFoundError for people that
    the trial lacks.
    """
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        whole = read_whole(tx, stored)
    if not has_markers(whole.head.skeleton):
        raise ConversionError(f"{stored.name!r} has a skeleton already.", remedy="Choose a document of markers.")
    people = solve_people(whole.head, whole.block)
    chosen = _choose(people, request.people)
    metres = metres_of(whole.head)
    items = []
    for person in chosen:
        name = request.name or (stored.name if len(people) > 1 else f"{stored.name} skeleton")
        if len(chosen) > 1 or (request.name is None and len(people) > 1):
            name = f"{name} {person.person}".strip()
        document = None if request.preview else _store(database, settings, stored, person, name, request, author)
        items.append(
            MadeSkeleton(
                document=document,
                name=name,
                person=person.person,
                frames=len(person.block),
                joints=[_describe(miss, 1.0 if metres is None else metres) for miss in person.misses],
                notices=[notice.what for notice in person.notices],
            )
        )
    return MadeSkeletons(items=items)


def _choose(people: list[SolvedPerson], wanted: list[str] | None) -> list[SolvedPerson]:
    if wanted is None:
        return people
    known = {person.person: person for person in people}
    unknown = [name for name in wanted if name not in known]
    if unknown:
        raise NotFoundError(
            f"The trial has no person {unknown[0]!r}.",
            remedy=f"It has: {', '.join(name or 'one without a prefix' for name in known)}.",
        )
    return [person for name, person in known.items() if name in wanted]


def _store(
    database: Database,
    settings: Settings,
    stored: StoredDocument,
    person: SolvedPerson,
    name: str,
    request: SkeletonsRequest,
    author: str,
) -> str:
    return store_stream(
        database,
        person.clip(),
        settings,
        name=name,
        project=request.project or stored.project,
        author=author,
        provenance={
            "analysis": "skeletons",
            "sources": [{"document": stored.uuid, "revision": stored.revision}],
            "parameters": {"person": person.person} if person.person else {},
        },
    )


def _describe(miss: Miss, metres: float) -> JointMiss:
    rms, most = (None if math.isnan(value) else value * metres for value in (miss.rms, miss.most))
    return JointMiss(joint=miss.joint, rms=rms, most=most, unknown=miss.unknown)
