"""The catalogue of analyses, and starting one: an endpoint each, made from its entry."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, File, Path, Request, Response, UploadFile
from pydantic import BaseModel, ConfigDict, Field, create_model

from schemas.examples import JOB, PROJECT, shown
from schemas.jobs import AnalysisInfo, AnalysisList, Job, MusicBeats, Selection
from service.actions.analysing.describe_job import analysis_answer, job_answer
from service.actions.analysing.read_music import read_music
from service.actions.analysing.start_analysis import find_analysis, start_analysis
from service.analysis.catalogue import ANALYSES
from service.analysis.interface import Analysis
from service.api.dependencies import AuthorDep, DatabaseDep, QueriesDep, SettingsDep
from service.formats.format import SourceFile

router = APIRouter(tags=["analyses"])


@router.get("/analyses", operation_id="list_analyses")
def list_analyses() -> AnalysisList:
    """Every analysis with its parameters, the parts of its results, and what can be done with them."""
    return AnalysisList(items=[analysis_answer(analysis) for analysis in ANALYSES.values()])


@router.get("/analyses/{name}", operation_id="get_analysis")
def get_analysis(name: str = Path(description="Name of the analysis", examples=["beats"])) -> AnalysisInfo:
    """An analysis with its parameters as JSON schema."""
    return analysis_answer(find_analysis(name))


@router.post("/music", operation_id="read_music")
def post_music(
    settings: SettingsDep,
    file: Annotated[UploadFile, File(description="WAV, FLAC or MP3, at most 15 minutes", examples=["song.mp3"])],
) -> MusicBeats:
    """The beats of music, to be corrected and danced to. Needs the extra `audio`; nothing is kept."""
    return read_music(SourceFile(file.filename or "music", file.file), settings)


def _request(analysis: Analysis) -> type[BaseModel]:
    """The body of a request: a selection of documents, and the parameters of the analysis."""
    example = {"inputs": {"project": PROJECT}, "name": f"{analysis.name} of {PROJECT}"}
    grown: dict[str, Any] = {
        "extends": (str | None, Field(None, description="Result that these documents are added to, without rebuild"))
    }
    model: type[BaseModel] = create_model(
        f"{''.join(word.title() for word in analysis.name.split('-'))}Request",
        __config__=ConfigDict(extra="forbid", json_schema_extra=shown(example)),
        __doc__=f"Clips and parameters of {analysis.title.lower()}.",
        inputs=(Selection, ...),
        parameters=(analysis.parameters, Field(default_factory=analysis.parameters)),
        name=(str | None, Field(None, max_length=1024, description="Name of the result")),
        project=(str | None, Field(None, max_length=256, description="Project of the result; default the documents'")),
        skeleton=(
            str | None,
            Field(None, description="Id of a document: clips are brought onto its skeleton when they are read"),
        ),
        **(grown if analysis.extend else {}),
    )
    return model


def _offer(analysis: Analysis) -> None:
    model = _request(analysis)

    def start(
        request: model,  # type: ignore[valid-type]  # one model for each entry of the catalogue
        http: Request,
        response: Response,
        database: DatabaseDep,
        settings: SettingsDep,
        queries: QueriesDep,
        author: AuthorDep,
    ) -> Job:
        body: Any = request
        uuid = start_analysis(
            database,
            queries,
            settings,
            analysis,
            body.inputs,
            body.parameters.model_dump(mode="json"),
            author=author,
            name=body.name,
            project=body.project,
            extends=getattr(body, "extends", None),
            skeleton=body.skeleton,
        )
        http.app.state.runner.wake()
        response.headers["location"] = f"/api/v1/jobs/{uuid}"
        with database.read() as tx:
            return job_answer(tx.jobs.get(uuid))

    # Annotations are texts in this module; the model is not known by a name that FastAPI could look up.
    start.__annotations__["request"] = model
    router.add_api_route(
        f"/analyses/{analysis.name}",
        start,
        methods=["POST"],
        status_code=202,
        operation_id=f"start_{analysis.name.replace('-', '_')}",
        summary=analysis.title,
        description=f"{analysis.description}\n\nRuns as a job: follow `Location`, such as `/api/v1/jobs/{JOB}`.",
    )


for _analysis in ANALYSES.values():
    _offer(_analysis)


@router.post("/analyses/{name}", include_in_schema=False)
def start_unknown(name: str) -> None:
    """The list of analyses, for a name that is none. Behind all of them, so that it is reached by no other."""
    find_analysis(name)
