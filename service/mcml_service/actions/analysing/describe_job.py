"""Jobs, results and analyses in the words of the API."""

from __future__ import annotations

from pydantic import BaseModel

from mcml_schemas.jobs import (
    AnalysisInfo,
    ArrayInfo,
    Job,
    JobInput,
    OperationInfo,
    PartKind,
    PartSummary,
    Result,
)
from mcml_schemas.problem import Problem
from mcml_service.actions.analysing.start_analysis import LEFT_OUT
from mcml_service.analysis.catalogue import ANALYSES, SUBJECTS
from mcml_service.analysis.interface import Analysis
from mcml_service.storage.work.jobs import StoredJob
from mcml_service.storage.work.results import StoredPart, StoredResult


def job_answer(job: StoredJob) -> Job:
    return Job(
        id=job.uuid,
        analysis=job.analysis,
        name=job.name,
        project=job.project,
        owner=job.owner,
        state=job.state,
        stage="cancelling" if job.cancel and job.state == "running" else job.stage,
        share=min(1.0, max(0.0, job.share)),
        attempt=job.attempt,
        inputs=[JobInput(**item) for item in job.inputs],
        left_out=job.parameters.get(LEFT_OUT, 0),
        parameters=job.parameters,
        created=job.created,
        started=job.started,
        ended=job.ended,
        problem=None if job.problem is None else Problem(**job.problem),
        result=job.result,
    )


def result_answer(result: StoredResult, parts: list[StoredPart] | None = None) -> Result:
    """parts: None in lists."""
    analysis = ANALYSES.get(result.analysis)
    return Result(
        id=result.uuid,
        analysis=result.analysis,
        name=result.name,
        project=result.project,
        owner=result.owner,
        parent=result.parent,
        inputs=[JobInput(**item) for item in result.inputs],
        parameters=result.parameters,
        made_with=result.made_with,
        created=result.created,
        parts={part.name: part_answer(part) for part in parts or ()},
        operations=list(analysis.operations) if analysis and parts is not None else [],
    )


def part_answer(part: StoredPart) -> PartSummary:
    return PartSummary(
        kind=part.kind,
        data=part.data,
        arrays={name: ArrayInfo(**about) for name, about in part.arrays.items()},
        document=part.document,
    )


def analysis_answer(analysis: Analysis) -> AnalysisInfo:
    subject, verb = place_of(analysis)
    return AnalysisInfo(
        name=analysis.name,
        subject=subject,
        verb=verb,
        title=analysis.title,
        description=analysis.description,
        parameters=analysis.parameters.model_json_schema(),
        parts={name: PartKind(kind=part.kind, description=part.description) for name, part in analysis.parts.items()},
        operations={
            name: OperationInfo(
                description=operation.description,
                parameters=operation.parameters.model_json_schema(),
                answer=_schema(operation.answer),
            )
            for name, operation in analysis.operations.items()
        },
        pictures={name: picture.description for name, picture in analysis.pictures.items()},
        rules=dict(analysis.rules),
        fewest=analysis.fewest,
        most=analysis.most,
    )


def place_of(analysis: Analysis) -> tuple[str, str]:
    """Its subject and verb in the catalogue."""
    return next(
        (subject, verb)
        for subject, verbs in SUBJECTS.items()
        for verb, other in verbs.items()
        if other.name == analysis.name
    )


def _schema(model: type[BaseModel]) -> dict[str, object]:
    return model.model_json_schema(mode="serialization")
