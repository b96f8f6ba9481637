"""Analyses: the catalogue; and from each of its entries an operation that starts it, and those on its results."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from typing import Annotated, Any

import orjson
from pydantic import BaseModel, Field, create_model

from mcml.answers import Content
from mcml.errors import NotFoundError, SizeError
from mcml.formats.format import SourceFile
from mcml.motion.hub import walked
from mcml_schemas.analyses.dance import BeatsPerBar
from mcml_schemas.examples import DOCUMENT, JOB, PROJECT, example_of, shown
from mcml_schemas.jobs import AnalysisInfo, AnalysisList, ClipMotion, Job, MusicBeats, ResultUsed, Saving, Selection
from mcml_schemas.request_body import RequestBody
from mcml_service.actions.analysing.describe_job import analysis_answer, job_answer
from mcml_service.actions.analysing.read_music import read_music as beats_of
from mcml_service.actions.analysing.start_analysis import find_analysis, start_analysis
from mcml_service.actions.analysing.use_result import Done
from mcml_service.actions.importing.store_clip import clip_file
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.interface import Analysis, MadeClip
from mcml_service.analysis.interface import ResultUse as Use
from mcml_service.operations.call import Call
from mcml_service.operations.operation import Effect, Operation, Right, Upload, gives
from mcml_service.operations.results import INLINE_NUMBERS, ResultId, npy


def list_analyses(call: Call) -> AnalysisList:
    return AnalysisList(items=[analysis_answer(analysis) for analysis in ANALYSES.values()])


def get_analysis(
    call: Call, name: Annotated[str, Field(description="Name of the analysis", examples=["beats"])]
) -> AnalysisInfo:
    return analysis_answer(find_analysis(name))


def read_music(
    call: Call,
    file: Annotated[
        SourceFile, Upload(), Field(description="WAV, FLAC or MP3, at most 15 minutes", examples=["song.mp3"])
    ],
    bpm: Annotated[
        float | None, Field(ge=40, le=240, description="Beats a minute, where the tempo is known", examples=[150])
    ] = None,
    beats_per_bar: Annotated[
        BeatsPerBar | None, Field(description="Beats of a bar, where they are known", examples=[3])
    ] = None,
) -> MusicBeats:
    """Needs the extra `audio`; nothing is stored. Tempi that fit nearly as well are listed as rivals."""
    return beats_of(file, call.settings, bpm, beats_per_bar)


def make_operations() -> Iterator[Operation]:
    """The operations that the catalogue makes: to start each analysis, and to use its results."""
    for analysis in ANALYSES.values():
        yield Operation(
            f"start_{analysis.name.replace('-', '_')}",
            f"POST /analyses/{analysis.name}",
            Effect.STARTS,
            Right.EDIT,
            analysis.description,
            summary=analysis.title,
            module="analyses",
            status=202,
            implementation=_starting(analysis),
        )
    for analysis in ANALYSES.values():
        for name, use in analysis.operations.items():
            yield Operation(
                f"use_{name.replace('-', '_')}",
                f"POST /results/{{id}}/{name}",
                Effect.WRITES,
                Right.EDIT,
                use.description,
                summary=use.description.partition(".")[0],
                module="results",
                omit_null=True,
                implementation=_using(name, use),
            )


def _starting(analysis: Analysis) -> Callable[..., Job]:
    def start(call: Call, request: Any) -> Job:
        uuid = start_analysis(
            call.database,
            call.queries,
            call.settings,
            analysis,
            request.inputs,
            request.parameters.model_dump(mode="json"),
            author=call.author,
            name=request.name,
            project=request.project,
            runner=call.repository.runner,
            extends=getattr(request, "extends", None),
            skeleton=getattr(request, "skeleton", None),
        )
        call.repository.wake()
        call.created = f"jobs/{uuid}"
        with call.database.read() as tx:
            return job_answer(tx.jobs.get(uuid))

    start.__doc__ = f"Runs as a job: follow `Location`, such as `/api/v1/jobs/{JOB}`."
    start.__annotations__ = {"call": Call, "request": _request(analysis), "return": Job}
    return start


def _request(analysis: Analysis) -> type[BaseModel]:
    """The body of a request: a selection of documents, and the parameters of the analysis."""
    example = {"inputs": {"project": PROJECT}, "name": f"{analysis.name} of {PROJECT}"}
    grown: dict[str, Any] = {
        "extends": (str | None, Field(None, description="Result that these documents are added to, without rebuild"))
    }
    fitted: dict[str, Any] = {
        "skeleton": (
            str | None,
            Field(None, description="Id of a document: clips are brought onto its skeleton when they are read"),
        )
    }
    model: type[BaseModel] = create_model(
        f"{''.join(word.title() for word in analysis.name.split('-'))}Request",
        __base__=RequestBody,
        __cls_kwargs__={"json_schema_extra": shown(example)},
        __doc__=f"Clips and parameters of {analysis.title.lower()}.",
        inputs=(Selection, ...),
        parameters=(analysis.parameters, Field(default_factory=analysis.parameters)),
        name=(str | None, Field(None, max_length=1024, description="Name of the result")),
        project=(str | None, Field(None, max_length=256, description="Project of the result; default the documents'")),
        **(fitted if analysis.reads == "motions" else {}),
        **(grown if analysis.extend else {}),
    )
    return model


def _using(name: str, used: Use) -> Callable[..., Any]:
    asked, told = _request_model(name, used), _answer_model(name, used)

    def use(call: Call, id: str, request: Any, format: str = "json", positions: bool = False) -> Any:
        done = call.results.use(
            id,
            name,
            request.parameters.model_dump(mode="json"),
            author=call.author,
            save=request.save,
            name=request.name,
            project=request.project,
        )
        if format == "block":
            return motion_block(told(value=done.answer.value, document=done.document, result=done.result), done)
        if format != "json":
            return _clip_file(done, format)
        clip = None if done.answer.clip is None else _motion(done.answer.clip, positions)
        return told(value=done.answer.value, clip=clip, document=done.document, result=done.result)

    words = (
        "json; block: the answer as JSON, then positions as f4 (docs/api/analyses.md); or the clip alone: npy "
        "(positions: frames, joints, 3), or bvh, htr, mcml …"
    )
    use.__annotations__ = {
        "call": Call,
        "id": ResultId,
        "request": asked,
        "format": Annotated[str, Field(description=words, examples=["json"])],
        "positions": Annotated[bool, Field(description="Put joint positions of every frame into the JSON")],
        "return": told | Content,
    }
    file = "Result of the action; with another `format` only the clip, as a file"
    return gives(file, {"application/octet-stream": None})(use)


def _request_model(name: str, used: Use) -> type[BaseModel]:
    needed = any(field.is_required() for field in used.parameters.model_fields.values())
    model: type[BaseModel] = create_model(
        f"{name.title().replace('-', '')}Request",
        __base__=Saving,
        __doc__=used.description,
        parameters=(used.parameters, ... if needed else Field(default_factory=used.parameters)),
    )
    model.model_config["json_schema_extra"] = shown({"parameters": example_of(used.parameters), "save": False})
    model.model_rebuild(force=True)
    return model


def _answer_model(name: str, used: Use) -> type[BaseModel]:
    example = {"value": example_of(used.answer), "document": DOCUMENT}
    model: type[BaseModel] = create_model(
        f"{name.title().replace('-', '')}Done",
        __base__=ResultUsed,
        __doc__=ResultUsed.__doc__,
        value=(used.answer, ...),
    )
    model.model_config["json_schema_extra"] = shown(example)
    model.model_rebuild(force=True)
    return model


def _motion(clip: MadeClip, positions: bool) -> ClipMotion:
    world = walked(clip.skeleton, clip.translations, clip.rotations)[0] if positions else None
    if world is not None and world.size > INLINE_NUMBERS:
        raise SizeError(f"The clip has {world.size:,} numbers.", remedy="Fetch it with format=npy.")
    return ClipMotion(
        name=clip.name,
        frames=len(clip.rotations),
        seconds_per_frame=clip.frame_time,
        joints=list(clip.skeleton.names),
        parents=[joint.parent for joint in clip.skeleton.joints],
        positions=None if world is None else world.round(5).tolist(),
    )


def motion_block(told: BaseModel, done: Done) -> Content:
    """An answer for an eye: the length of its JSON as u4, the JSON, then positions as f4. The JSON has the head of the
    motion as `motion`, and spaces at its end so that the numbers are aligned."""
    from mcml_service.actions.analysing.show_motion import show_motion

    clip = done.answer.clip
    if clip is None:
        raise NotFoundError("The operation makes no clip.", remedy="Ask for format=json.")
    head, positions = show_motion(clip)
    text = orjson.dumps({**told.model_dump(mode="json", exclude_none=True), "motion": head.model_dump(mode="json")})
    text += b" " * (-len(text) % 4)
    blocks = [struct.pack("<I", len(text)) + text, positions.tobytes()]
    return Content(iter(blocks), "application/octet-stream", f"{clip.name}.block", size=sum(map(len, blocks)))


def _clip_file(done: Done, format: str) -> Content:
    clip = done.answer.clip
    if clip is None:
        raise NotFoundError("The operation makes no clip.", remedy="Ask for format=json.")
    facts = {} if done.document is None else {"document": done.document}
    if format == "npy":
        answer = npy(walked(clip.skeleton, clip.translations, clip.rotations)[0].astype("<f4"), clip.name)
    else:
        file_name, media_type, content = clip_file(clip, format)
        answer = Content(iter([content]), media_type, file_name)
    answer.facts |= facts
    return answer
