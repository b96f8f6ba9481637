"""Uploaded files: stored as documents, or only inspected."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from mcml.answers import UploadError
from mcml.files.import_options import ImportOptions, checked_repairs, parse_label, parse_property
from mcml.formats.format import SourceFile
from mcml_schemas.catalogues import DemoLoaded, DemoPart
from mcml_schemas.documents import FileProblem, InspectResult, UploadResult
from mcml_schemas.examples import DOCUMENT, MOTION_NAME, PROJECT
from mcml_schemas.frame_time import FrameTime
from mcml_schemas.revisions import FileReplaced
from mcml_service.actions.checking.describe_problem import problem_of
from mcml_service.actions.importing.upload_files import upload_files
from mcml_service.operations.arguments import DocumentId, IfMatch, Shown, find_for_write
from mcml_service.operations.call import Call
from mcml_service.operations.operation import Upload

Files: TypeAlias = Annotated[
    list[SourceFile],
    Upload(),
    Field(
        description="FBX, glTF, VRM, USD, AMASS npz, MVNX, ARKit CSV, BVH, ASF and AMC, HTR, C3D, TRC, MCML, archives",
        examples=[["walk.bvh"]],
    ),
]
Repairs: TypeAlias = Annotated[
    list[str] | None,
    Field(
        description="Repairs of text files before they are read: split-numbers, decimal-commas, missing-samples, "
        "stated-dof, three-dof, whole-frames; may be repeated",
        examples=[["split-numbers"]],
    ),
]
Translation: TypeAlias = Annotated[
    Literal["auto", "absolute", "relative"],
    Field(description="Whether translations of joints replace their offsets, or are added to them"),
]
Encoding: TypeAlias = Annotated[str | None, Field(description="Text encoding, if it is not UTF-8", examples=["cp949"])]


Take: TypeAlias = Annotated[
    str | None,
    Field(max_length=1024, description="One motion of a file that holds several; default all", examples=["Walk"]),
]
Rate: TypeAlias = Annotated[
    float | None,
    Field(
        gt=0,
        le=10_000,
        description="Frames a second at which keys are sampled, where a file has no rate or another is wanted",
        examples=[60],
    ),
]


def upload_documents(
    call: Call,
    file: Files,
    project: Annotated[
        str, Field(min_length=1, max_length=256, description="Project to store into; made if new", examples=[PROJECT])
    ] = "default",
    name: Annotated[
        str | None, Field(max_length=1024, description="Name of the document; default the file's", examples=["walk"])
    ] = None,
    description: Annotated[
        str, Field(max_length=100_000, description="Description", examples=["A walk on flat ground."])
    ] = "",
    label: Annotated[
        list[str] | None,
        Field(
            description="Motion name: NAME or NAME:FIRST-LAST; may be repeated", examples=[[f"{MOTION_NAME}:100-142"]]
        ),
    ] = None,
    property: Annotated[
        list[str] | None,
        Field(description="NAME=VALUE or NAME=VALUE UNIT; may be repeated", examples=[["age=23 year"]]),
    ] = None,
    encoding: Encoding = None,
    translation: Translation = "auto",
    unit: Annotated[
        str | None, Field(description="Length unit of the files: mm, cm, m, inch …", examples=["cm"])
    ] = None,
    up: Annotated[str | None, Field(description="Axis that points up", examples=["Y"])] = None,
    frame_time: Annotated[
        FrameTime | None,
        Field(
            description="Seconds a frame, where the files do not say, as 0.0083333 or 1/120",
            examples=["0.0083333"],
        ),
    ] = None,
    skeleton: Annotated[
        str | None, Field(description="Stored document whose ASF to use for an AMC without one", examples=[DOCUMENT])
    ] = None,
    on_duplicate: Annotated[
        Literal["new", "skip"], Field(description="Action for files that are already in the store")
    ] = "new",
    take: Take = None,
    rate: Rate = None,
    repair: Repairs = None,
    strict_names: Annotated[bool, Field(description="Refuse labels that are no anatomical movement")] = False,
    movements: Annotated[
        float | None,
        Field(
            ge=0,
            le=1,
            description="Name anatomical movements found in the motion with at least this confidence",
            examples=[0.7],
        ),
    ] = None,
) -> UploadResult:
    """Each document is stored whole or not at all; problems name the files that were not, and `details.repairs` what of
    `repair` would do something to them.
    """
    options = ImportOptions(
        project=project,
        name=name,
        description=description,
        labels=tuple(parse_label(text) for text in label or ()),
        properties=tuple(parse_property(text) for text in property or ()),
        encoding=encoding,
        translation=translation,
        unit=unit,
        up=up,
        frame_time=frame_time,
        skeleton=skeleton,
        on_duplicate=on_duplicate,
        strict_names=strict_names,
        movements=movements,
        take=take,
        rate=rate,
        repair=checked_repairs(repair or ()),
    )
    pool = call.repository.import_pool
    result = upload_files(
        call.database, file, options, call.settings, author=call.author, progress=call.progress, pool=pool
    )
    if result.problems and not result.documents:
        raise UploadError(result.problems)
    if result.documents:
        call.created = f"documents/{result.documents[0].id}"
    return result


def inspect_files(
    call: Call,
    file: Files,
    shown: Shown,
    encoding: Encoding = None,
    take: Take = None,
    rate: Rate = None,
    repair: Repairs = None,
) -> InspectResult:
    """Nothing is stored."""
    from mcml_service.actions.reading import inspect_files as inspecting

    options = ImportOptions(encoding=encoding, take=take, rate=rate, repair=checked_repairs(repair or ()))
    clips, problems = inspecting.inspect_files(file, options, call.settings, shown.window)
    return InspectResult(
        clips=clips, problems=[FileProblem(file=name, problem=problem_of(error)) for name, error in problems]
    )


def replace_file(
    call: Call,
    id: DocumentId,
    file: Files,
    encoding: Encoding = None,
    translation: Translation = "auto",
    take: Take = None,
    rate: Rate = None,
    repair: Repairs = None,
    replace_skeleton: Annotated[
        bool,
        Field(description="Replace skeleton, unit and frame rate where they differ; without it such a file fails"),
    ] = False,
    dry_run: Annotated[bool, Field(description="Only compare, change nothing")] = False,
    if_match: IfMatch = None,
) -> FileReplaced:
    """The file has the joints, the unit and the frame rate of the document, unless `replace_skeleton` is true. Frames
    that differ are replaced, as one revision; labels keep their frame numbers. An AMC without an ASF uses the
    document's. The first uploaded file stays as `format=original`.
    """
    from mcml_service.actions.importing.replace_motion import read_motion, replace_motion

    options = ImportOptions(
        encoding=encoding, translation=translation, take=take, rate=rate, repair=checked_repairs(repair or ())
    )
    new = read_motion(call.database, id, file, options, call.settings.file_limits)
    if dry_run:
        with call.database.read() as tx:
            return replace_motion(tx, tx.documents.get(id), new, replace_skeleton=replace_skeleton, dry_run=True)
    with call.database.write(call.author) as tx:
        return replace_motion(tx, find_for_write(tx, id, if_match), new, replace_skeleton=replace_skeleton)


def load_demo(
    call: Call,
    part: Annotated[
        list[DemoPart] | None, Field(description="Parts to load, default all; may be repeated", examples=[["walks"]])
    ] = None,
    project: Annotated[
        str | None,
        Field(
            min_length=1,
            max_length=256,
            description="Project for all clips; default: `demo`, `demo-reach` and others, by part",
            examples=[PROJECT],
        ),
    ] = None,
    seed: Annotated[
        int,
        Field(
            ge=0, le=1_000_000, description="Seed of the generated clips; another seed makes other clips", examples=[1]
        ),
    ] = 1,
) -> DemoLoaded:
    """Clips that are stored already are skipped, so a second call with the same seed stores nothing.

    All parts take several seconds; to show progress, load one part after another.
    """
    # Imported late, as all mathematics.
    from mcml_service.actions.importing import load_demo as loading

    parts = loading.load_demo(
        call.database,
        call.settings,
        part or tuple(loading.PROJECTS),
        project=project,
        seed=seed,
        author=call.author,
        pool=call.repository.import_pool,
    )
    return DemoLoaded(
        stored=sum(each.stored for each in parts), existing=sum(each.existing for each in parts), parts=parts
    )
