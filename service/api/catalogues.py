"""What the repository knows: formats, joint names, motion names, skeletons, projects."""

from __future__ import annotations

from fastapi import APIRouter

from schemas.catalogues import (
    BodyPart,
    FormatInfo,
    FormatList,
    FormatPart,
    JointName,
    JointNameList,
    MotionNameInUse,
    MotionNameList,
    ProjectList,
    SkeletonInfo,
    SkeletonPage,
    UnsupportedFormat,
)
from service.api.dependencies import DatabaseDep, PageDep, ProjectQuery, decode_cursor, encode_cursor
from service.formats import FORMATS, UNSUPPORTED
from service.mcml import joint_names, motion_names

router = APIRouter(tags=["catalogues"])


@router.get("/formats", operation_id="list_formats")
def list_formats() -> FormatList:
    """Formats that are read and written, and those that are known but not read, with the reason."""
    items = [
        FormatInfo(
            name=format_.name,
            title=format_.title,
            parts=[
                FormatPart(name=part.name, title=part.title, extensions=list(part.extensions)) for part in format_.parts
            ],
            convention=format_.convention.value,
        )
        for format_ in FORMATS.values()
    ]
    mcml = FormatPart(name="mcml", title="Motion Capture Markup Language", extensions=[".mcml", ".xml"])
    items.append(FormatInfo(name="mcml", title=mcml.title, parts=[mcml], convention="any"))
    return FormatList(
        items=items, unsupported=[UnsupportedFormat(name=name, why=why) for name, why in UNSUPPORTED.items()]
    )


@router.get("/joint-names", operation_id="list_joint_names")
def list_joint_names() -> JointNameList:
    """The one table of joint names: MCML's own, and what other rigs call them."""
    return JointNameList(
        items=[
            JointName(
                number=row.number,
                name=row.name,
                reconstructed=row.reconstructed,
                aliases={
                    rig: [name for name in names.split("|") if name] for rig, names in row.columns.items() if names
                },
            )
            for row in joint_names.table()
        ]
    )


@router.get("/motion-names", operation_id="list_motion_names")
def list_motion_names(database: DatabaseDep, project: ProjectQuery = None) -> MotionNameList:
    """Motion names in use with their frames, and the movements that each part of the body can perform."""
    with database.read() as tx:
        used = tx.spans.counts(project)
    return MotionNameList(
        items=[MotionNameInUse(name=name, documents=documents, frames=frames) for name, documents, frames in used],
        vocabulary=[
            BodyPart(part=part.name, sided=part.sided, joints=list(part.joints), movements=list(part.movements))
            for part in motion_names.parts().values()
        ],
    )


@router.get("/skeletons", operation_id="list_skeletons")
def list_skeletons(database: DatabaseDep, page: PageDep, project: ProjectQuery = None) -> SkeletonPage:
    """Skeletons in use. Documents with equal skeletons share one."""
    after = 0 if page.cursor is None else int(decode_cursor(page.cursor, int)[0])
    with database.read() as tx:
        key = None if project is None else tx.projects.get(project)
        rows = tx.heads.skeletons(key, after, page.limit + 1)
    shown = rows[: page.limit]
    return SkeletonPage(
        items=[SkeletonInfo(id=row.id, hash=row.hash, joints=row.joints, documents=row.documents) for row in shown],
        next_cursor=encode_cursor(shown[-1].id) if len(rows) > page.limit else None,
    )


@router.get("/projects", operation_id="list_projects")
def list_projects(database: DatabaseDep) -> ProjectList:
    """Projects by name. Uploading into a new name makes it."""
    with database.read() as tx:
        return ProjectList(items=tx.projects.names())
