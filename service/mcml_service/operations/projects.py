"""Whole projects: how much is in them, archived, as one file, and made of one."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field

from mcml.answers import Content
from mcml.errors import AccessError
from mcml.files.check_names import given_name
from mcml.formats.format import SourceFile
from mcml_schemas.catalogues import ProjectChange, ProjectImported, ProjectView
from mcml_schemas.examples import PROJECT
from mcml_service.operations.call import Call
from mcml_service.operations.operation import Upload, gives
from mcml_service.storage.core.identifiers import now
from mcml_service.storage.core.views import may
from mcml_service.storage.transaction import Transaction

ProjectName = Annotated[str, Field(min_length=1, max_length=256, description="Name of the project", examples=[PROJECT])]


@gives("A zip, made while it is sent", {"application/zip": None})
def export_project(call: Call, project: ProjectName) -> Content:
    """Its documents as MCML, the files that they came of, and everything with every revision, of which `import_project`
    makes it again. Equal projects make equal files.
    """
    from mcml_service.actions.keeping.move_project import export_project as exporting

    # Not from a replica: a long answer without a tag could not continue if the replica became unreachable.
    tx = call.held.enter_context(call.database.for_call(call.view).read())
    tx.quotas.require(tx.projects.get(project), "own")
    return Content(exporting(tx, project), "application/zip", f"{project}.project.zip")


def create_project(call: Call, project: ProjectName) -> ProjectView:
    """It can have members and quotas before its first document. A project of this name is left as it is.

    Uploading into a new name creates a project too.
    """
    name = given_name(project, "project")
    with call.database.write(call.author) as tx:
        tx.order()
        call.made = tx.projects.find(name) is None
        key = tx.projects.get_or_add(name)
        if call.made:
            tx.activity.note("project", "add", project_key=key, subject=name)
        return _view(tx, key)


def get_project(call: Call, project: ProjectName) -> ProjectView:
    with call.database.read() as tx:
        return _view(tx, tx.projects.get(project))


def change_project(call: Call, change: ProjectChange, project: ProjectName) -> ProjectView:
    """An archived project is read-only until it is opened again; reading and exporting still work.

    New data over a quota is refused. Existing data is kept. With `review_required`, direct changes of documents are
    refused: editors propose them, and another editor approves them.
    """
    with call.database.write(call.author) as tx:
        tx.order()
        key = tx.projects.get(project)
        tx.quotas.require(key, "own")
        bounds = {name: getattr(change, name) for name in ("most_documents", "most_bytes")}
        changes: dict[str, Any] = {name: bound or None for name, bound in bounds.items() if bound is not None}
        if changes and not may(call.view.everywhere, "operate"):
            raise AccessError(
                "Owners of the repository say how much a project may hold.", remedy="Ask one of them for more room."
            )
        chosen = replace(tx.quotas.of(key), **changes)
        if change.archived is not None:
            since = chosen.archived or now()
            chosen = replace(chosen, archived=since if change.archived else None)
        if change.review_required is not None:
            chosen = replace(chosen, review_required=change.review_required)
        tx.quotas.put(key, chosen)
        tx.activity.note("project", "change", project_key=key, subject=project)
        return _view(tx, key)


def import_project(
    call: Call,
    file: Annotated[SourceFile, Upload(), Field(description="An exported project file", examples=["gait.project.zip"])],
    name: Annotated[
        str | None, Field(min_length=1, max_length=256, description="Default: as it was called", examples=["gait 2"])
    ] = None,
) -> ProjectImported:
    """Imports every revision, or nothing.

    Authors stay as text, no accounts are created; ids already in use are replaced.
    """
    from mcml_service.actions.keeping.move_project import import_project as importing

    project, documents = importing(call.database, file.stream, call.settings, call.author, name)
    return ProjectImported(project=project, documents=documents)


def _view(tx: Transaction, key: int) -> ProjectView:
    documents, size = tx.quotas.measure(key)
    return ProjectView(name=tx.projects.name(key), documents=documents, bytes=size, **vars(tx.quotas.of(key)))
