"""Catalogues of the repository: formats, joint names, motion names, skeletons, projects."""

from __future__ import annotations

from importlib.util import find_spec

from mcml.formats import FORMATS, NEEDED, UNSUPPORTED, WRITERS
from mcml.language import joint_names, motion_names
from mcml.language.elements import to_head
from mcml.motion.kinematics import rest_positions
from mcml.motion.units import reading_of
from mcml_schemas.catalogues import (
    BodyPart,
    FormatInfo,
    FormatList,
    FormatPart,
    JointName,
    JointNameList,
    MotionNameInUse,
    MotionNameList,
    ProjectList,
    RestPose,
    SkeletonInfo,
    SkeletonPage,
    UnsupportedFormat,
)
from mcml_service.operations.arguments import AtRevision, DocumentId, InProject, Page, at_revision, tag
from mcml_service.operations.call import Call


def list_formats(call: Call) -> FormatList:
    items = [
        FormatInfo(
            name=format_.name,
            title=format_.title,
            label=format_.label,
            parts=[
                FormatPart(name=part.name, title=part.title, extensions=list(part.extensions)) for part in format_.parts
            ],
            convention="any" if format_.convention is None else format_.convention.value,
            bodies=format_.bodies,
            markers=format_.markers,
            needs=sorted(format_.needs),
            assumes=format_.assumes,
            reads=format_.name in FORMATS,
            writes=find_spec(NEEDED.get(format_.name, "mcml")) is not None,
        )
        for format_ in WRITERS.values()
    ]
    mcml = FormatPart(name="mcml", title="Motion Capture Markup Language", extensions=[".mcml", ".xml"])
    about = {"title": mcml.title, "label": "MCML", "convention": "any", "needs": [], "assumes": ""}
    items.append(FormatInfo(name="mcml", parts=[mcml], bodies=True, markers=True, **about))
    return FormatList(
        items=items, unsupported=[UnsupportedFormat(name=name, why=why) for name, why in UNSUPPORTED.items()]
    )


def list_joint_names(call: Call) -> JointNameList:
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


def list_motion_names(call: Call, project: InProject = None) -> MotionNameList:
    with call.database.read() as tx:
        used = tx.spans.counts(project)
    return MotionNameList(
        items=[MotionNameInUse(name=name, documents=documents, frames=frames) for name, documents, frames in used],
        vocabulary=[
            BodyPart(part=part.name, sided=part.sided, joints=list(part.joints), movements=list(part.movements))
            for part in motion_names.parts().values()
        ],
    )


def list_skeletons(call: Call, page: Page, project: InProject = None) -> SkeletonPage:
    """Documents with equal skeletons share one."""
    after = page.after(int)
    with call.database.read() as tx:
        key = None if project is None else tx.projects.get(project)
        rows = tx.heads.skeletons(key, 0 if after is None else after[0], page.most(call) + 1)
    shown, more = page.cut(call, rows, lambda row: (row.id,))
    return SkeletonPage(
        items=[SkeletonInfo(id=row.id, hash=row.hash, joints=row.joints, documents=row.documents) for row in shown],
        next_cursor=more,
    )


def get_rest_pose(call: Call, id: DocumentId, revision: AtRevision = None) -> RestPose:
    """Return the rest pose of a skeleton, for drawing it."""
    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        call.set_tag(tag(stored, "rest"))
        head = to_head(then.heads.document(stored), stored.frame_time)
    positions = rest_positions(head.skeleton, reading_of(head))[: len(head.skeleton.joints)]
    return RestPose(
        joints=list(head.skeleton.names),
        parents=[joint.parent for joint in head.skeleton.joints],
        positions=positions.round(6).tolist(),
    )


def list_projects(call: Call) -> ProjectList:
    """Uploading into a new name makes it."""
    with call.database.read() as tx:
        return ProjectList(items=tx.projects.names())
