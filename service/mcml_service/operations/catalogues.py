"""Catalogues of the repository: formats, joint names, motion names, skeletons, projects."""

from __future__ import annotations

from dataclasses import asdict
from importlib.util import find_spec

from mcml.files.companions import BESIDE, STATES_BESIDE
from mcml.files.presets import PRESETS
from mcml.formats import NEEDED, READERS, SKINNED, UNSUPPORTED, WRITERS
from mcml.formats.format import TakesReader
from mcml.language import joint_names, motion_names
from mcml.language.elements import to_head
from mcml.motion.kinematics import rest_positions
from mcml.motion.retargeting.known_rigs import KNOWN_RIGS
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
    PresetInfo,
    ProjectList,
    RestPose,
    SkeletonInfo,
    SkeletonPage,
    UnsupportedFormat,
)
from mcml_schemas.retarget import KnownRigInfo, KnownRigs
from mcml_service.operations.arguments import AtRevision, DocumentId, InProject, Page, at_revision, tag
from mcml_service.operations.call import Call


def list_formats(call: Call) -> FormatList:
    items = [_describe_format(name) for name in dict.fromkeys([*READERS, *WRITERS])]
    mcml = FormatPart(name="mcml", title="Motion Capture Markup Language", extensions=[".mcml", ".xml"])
    about = {"title": mcml.title, "label": "MCML", "convention": "any", "needs": [], "assumes": ""}
    about |= {"extensions": list(mcml.extensions), "states": ["blend_shapes", "frame_time", "unit", "up"]}
    items.append(FormatInfo(name="mcml", parts=[mcml], bodies=True, markers=True, **about))
    return FormatList(
        items=items,
        presets=[PresetInfo.model_validate(asdict(preset)) for preset in PRESETS.values()],
        unsupported=[UnsupportedFormat(name=name, why=why) for name, why in UNSUPPORTED.items()],
    )


def _describe_format(name: str) -> FormatInfo:
    reader, writer = READERS.get(name), WRITERS.get(name)
    about = writer or reader
    assert about is not None
    convention = None if writer is None else writer.convention
    endings = [] if reader is None else [ending for part in reader.parts for ending in part.extensions]
    return FormatInfo(
        name=name,
        title=about.title,
        label=about.label,
        parts=[FormatPart(name=part.name, title=part.title, extensions=list(part.extensions)) for part in about.parts],
        convention="any" if convention is None else convention.value,
        bodies=writer is None or writer.bodies,
        markers=writer is not None and writer.markers,
        needs=[] if writer is None else sorted(writer.needs),
        assumes="" if writer is None else writer.assumes,
        states=[] if reader is None else sorted(reader.states),
        reads=reader is not None,
        takes=isinstance(reader, TakesReader),
        beside=list(BESIDE.get(name, ())),
        states_beside=list(STATES_BESIDE.get(name, ())),
        extensions=endings,
        skins=name in SKINNED,
        writes=writer is not None and find_spec(NEEDED.get(name, "mcml")) is not None,
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


def list_rigs(call: Call) -> KnownRigs:
    """Their joints have the names of the program, in a rest pose of a body of 1.75 m."""
    rigs = [(rig, len(rig.clip().head.skeleton)) for rig in KNOWN_RIGS.values()]
    items = [
        KnownRigInfo.model_validate({"name": rig.name, "title": rig.title, "unit": rig.unit, "up": rig.up, "joints": n})
        for rig, n in rigs
    ]
    return KnownRigs(items=items)


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
    """Projects without documents are listed too."""
    with call.database.read() as tx:
        return ProjectList(items=tx.projects.names())
