"""Store uploaded files as documents, with the requested options; report in models of the API."""

from __future__ import annotations

from mcml.errors import McmlError
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_schemas.documents import FileProblem, ImportedDocument, NoticeLine, Receipt, UploadResult
from mcml_service.actions.checking.describe_problem import problem_of
from mcml_service.actions.importing.encode_clip import Progress
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.actions.importing.import_pool import ImportPool
from mcml_service.settings import Settings
from mcml_service.storage.database import Database


def upload_files(
    database: Database,
    files: list[SourceFile],
    options: ImportOptions,
    settings: Settings,
    *,
    author: str = "local",
    progress: Progress | None = None,
    pool: ImportPool | None = None,
) -> UploadResult:
    """Store every clip among the files; a bad one is a problem in the answer and does not stop the others.

    On request, movements are labelled in a separate revision, which can be undone without changing the upload. If they
    cannot be labelled, a notice of the receipt has the reason.
    """
    done = import_files(database, files, options, settings, author=author, progress=progress, pool=pool)
    documents = []
    for item in done.documents:
        document = ImportedDocument(
            id=item.uuid,
            name=item.name,
            file=item.file,
            skipped=item.skipped,
            receipt=Receipt(**item.receipt),
            calibration=f"/api/v1/documents/{item.uuid}/calibration",
        )
        if options.movements is not None and not item.skipped:
            _name_movements(database, document, options.movements, author)
        documents.append(document)
    problems = [FileProblem(file=name, problem=problem_of(error)) for name, error in done.problems]
    return UploadResult(documents=documents, problems=problems)


def _name_movements(database: Database, document: ImportedDocument, confidence: float, author: str) -> None:
    # Imported late, as all mathematics: an import needs none.
    from mcml_service.actions.labelling.suggest_labels import accept_movement_names

    try:
        document.movements = accept_movement_names(database, document.id, confidence, author)
    except McmlError as error:
        why = f"no movements are named: {error.what}"
        document.receipt.notices.append(NoticeLine(kind="note", what=why))
