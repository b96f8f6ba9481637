"""Whole projects: as one file, and made of one."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from schemas.catalogues import ProjectImported
from schemas.examples import PROJECT
from service.formats.format import SourceFile
from service.operations.call import Call, Content
from service.operations.operation import Upload, gives
from service.storage.views import require

ProjectName = Annotated[str, Field(min_length=1, max_length=256, description="Name of the project", examples=[PROJECT])]


@gives("A zip, made while it is sent", {"application/zip": None})
def export_project(call: Call, project: ProjectName) -> Content:
    """Its documents as MCML, the files that they came of, and everything with every revision, of which `import_project`
    makes it again. Equal projects make equal files.
    """
    from service.actions.keeping.move_project import export_project as exporting

    tx = call.read()
    require(tx, tx.projects.get(project), "own")
    return Content(exporting(tx, project), "application/zip", f"{project}.project.zip")


def import_project(
    call: Call,
    file: Annotated[SourceFile, Upload, Field(description="What the export of a project gave")],
    name: Annotated[
        str | None, Field(min_length=1, max_length=256, description="Default: as it was called", examples=["gait 2"])
    ] = None,
) -> ProjectImported:
    """With every revision, or nothing at all. Authors stay as text, nobody gets an account; ids that are taken here
    become others.
    """
    from service.actions.keeping.move_project import import_project as importing

    project, documents = importing(call.database, file.stream, call.settings, call.author, name)
    return ProjectImported(project=project, documents=documents)
