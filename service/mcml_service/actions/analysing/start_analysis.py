"""Start an analysis: its documents, their revisions and the parameters, as a job."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

from mcml.errors import NotFoundError, SizeError
from mcml.files.check_names import given_name
from mcml.motion.solving.marker_skeleton import has_markers
from mcml_schemas.jobs import Selection
from mcml_service.actions.composing.select_documents import select_captured, select_documents
from mcml_service.actions.editing.motion_processing import read_whole
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.interface import Analysis, AnalysisError
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries

EXTENDS, LEFT_OUT, SKELETON = "extends", "left_out", "skeleton_of"
"""Values beside the parameters of a job: the result that its documents are added to, the number of excluded clips,
and the document, {"document", "revision"}, to whose skeleton the clips are retargeted.
"""


def find_analysis(name: str) -> Analysis:
    """NotFoundError."""
    if name not in ANALYSES:
        raise NotFoundError(f"There is no analysis {name!r}.", remedy=f"There are: {', '.join(ANALYSES)}.")
    return ANALYSES[name]


def start_analysis(
    database: Database,
    queries: Queries,
    settings: Settings,
    analysis: Analysis,
    selection: Selection,
    parameters: dict[str, Any],
    *,
    author: str,
    name: str | None = None,
    project: str | None = None,
    runner: str | None = None,
    extends: str | None = None,
    skeleton: str | None = None,
) -> str:
    """Add a job for an analysis of the current revisions of the selected documents; return its uuid.

    project: of the result; default the documents' project, if they share one. runner: starts the job at once; else it
    waits for one. extends: a result that the documents are added to. skeleton: id of a document; the clips are
    retargeted to its skeleton when they are read. Raises AnalysisError for wrong parameters or too few documents,
    SizeError for too many.
    """
    checked = check_parameters(analysis.parameters, parameters)
    if extends is not None:
        with database.read() as tx:
            result = tx.results.get(extends)
        if analysis.extend is None or result.analysis != analysis.name or result.continues:
            raise AnalysisError(
                "not-extendable", f"{analysis.title} cannot add to this result.", remedy="Run the analysis again."
            )
        checked |= {EXTENDS: extends}
    selected, projects = select_documents(database, queries, selection)
    inputs = select_captured(database, selection, selected)
    if len(inputs) < len(selected):
        checked |= {LEFT_OUT: len(selected) - len(inputs)}
    if len(inputs) < (1 if extends else analysis.fewest):
        raise AnalysisError(
            "too-few-clips",
            f"{analysis.title} needs at least {analysis.fewest} documents; the selection has {len(inputs)}"
            + (f", and {len(selected) - len(inputs)} that an analysis made." if len(inputs) < len(selected) else "."),
            remedy="Widen the selection." + (" include_made takes these too." if len(inputs) < len(selected) else ""),
        )
    model = analysis.parameters.model_validate(parameters)
    analysis.check(model, [str(item["document"]) for item in inputs])
    if skeleton is not None:
        with database.read() as tx:
            body = tx.documents.get(skeleton)
            if has_markers(read_whole(tx, body, 1, 1).head.skeleton):
                raise AnalysisError(
                    "no-skeleton", f"{body.name} has markers only.", remedy="Name a document of a body."
                )
        checked |= {SKELETON: {"document": body.uuid, "revision": body.revision}}
    most = min(analysis.most, settings.job_clips)
    if len(inputs) > most:
        raise SizeError(
            f"The selection has {len(inputs)} documents; {analysis.title} takes {most}.", remedy="Narrow it."
        )
    target = project or (projects.pop() if len(projects) == 1 else "default")
    with database.write(author) as tx:
        return tx.jobs.add(
            tx.projects.get_or_add(given_name(target, "project")),
            analysis.name,
            given_name(name or f"{analysis.name} of {_words(selection, len(inputs))}", "result"),
            author,
            inputs,
            checked,
            runner,
        )


def check_parameters(model: Any, parameters: dict[str, Any]) -> dict[str, Any]:
    """The parameters with defaults, as plain values. AnalysisError names what does not fit."""
    try:
        checked: dict[str, Any] = model.model_validate(parameters).model_dump(mode="json")
    except ValidationError as error:
        fault = error.errors()[0]
        place = ".".join(str(part) for part in fault["loc"]) or "parameters"
        raise AnalysisError(
            "invalid-parameters", f"{place}: {fault['msg']}", remedy="See the parameters of the analysis."
        ) from error
    return checked


def _words(selection: Selection, count: int) -> str:
    return selection.project or selection.motion_name or ("1 clip" if count == 1 else f"{count} clips")
