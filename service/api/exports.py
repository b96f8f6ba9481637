"""Documents leaving the repository: MCML, and every format that can hold them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from schemas.examples import MCML
from service.actions.exporting.export_motion import Export, ExportOptions, export_document
from service.api.dependencies import DatabaseDep, DocumentId, First, Last, RevisionQuery, at_revision, etag
from service.api.streaming import attachment, streamed, unchanged
from service.formats import FORMATS
from service.storage.database import Transaction

router = APIRouter(tags=["export"])

_MCML: dict[int | str, dict[str, Any]] = {
    200: {"content": {"application/xml": {"example": MCML}}, "description": "The document"}
}
_TYPES = dict.fromkeys(
    [*(item.media_type for item in FORMATS.values()), "application/zip", "application/xml", "text/csv"]
)
_FILE: dict[int | str, dict[str, Any]] = {
    200: {
        "content": {name.partition(";")[0]: {} for name in _TYPES},
        "description": "The file: text in its own format, asf-amc a zip of both, mcml XML, csv a table of frames",
    }
}


@router.get("/documents/{id}/mcml", operation_id="get_mcml", response_class=Response, responses=_MCML)
def get_mcml(
    id: DocumentId,
    request: Request,
    database: DatabaseDep,
    revision: RevisionQuery = None,
    pretty: Annotated[bool, Query(description="Every element on a line of its own")] = False,
    first: First = 1,
    last: Last = None,
) -> Response:
    """The document as MCML, valid against `mcml.dtd`."""
    options = ExportOptions("mcml", first=first, last=last, pretty=pretty)
    return _answer(database, request, id, revision, options, inline=True)


@router.get("/documents/{id}/export", operation_id="export_document", response_class=Response, responses=_FILE)
def export(
    id: DocumentId,
    request: Request,
    database: DatabaseDep,
    format: Annotated[
        str, Query(description="bvh, asf-amc (a zip), asf, amc, htr, c3d, trc, mcml or csv", examples=["htr"])
    ],
    revision: RevisionQuery = None,
    first: First = 1,
    last: Last = None,
    names: Annotated[
        str | None,
        Query(description="Joint names: mcml, bvh1, bvh2, asf or htr; default the source's", examples=["mcml"]),
    ] = None,
    unit: Annotated[
        str | None, Query(description="Scale lengths to this unit; the document must state its own", examples=["mm"])
    ] = None,
    up: Annotated[str | None, Query(description="Turn so that this axis points up", examples=["Z"])] = None,
    original: Annotated[bool, Query(description="Answer the kept bytes of an unedited document")] = True,
) -> Response:
    """The document in a motion-capture format. In its own format an unedited one comes back byte for byte."""
    options = ExportOptions(format, first, last, names, unit, up, original=original)
    return _answer(database, request, id, revision, options, inline=False)


def _answer(
    database: DatabaseDep, request: Request, uuid: str, revision: int | None, options: ExportOptions, *, inline: bool
) -> Response:
    with database.read() as tx:
        _, stored = at_revision(tx, uuid, revision)
        tag = etag(stored, options.format)
        if options.whole and not options.pretty:
            cached = unchanged(request, tag)
            if cached is not None:
                return cached

    def make(tx: Transaction) -> tuple[Iterator[bytes], str, dict[str, str]]:
        then, stored = at_revision(tx, uuid, revision)
        export: Export = export_document(then, stored, options)
        headers = {"content-disposition": attachment(export.file_name)}
        if inline:
            headers["content-disposition"] = headers["content-disposition"].replace("attachment", "inline", 1)
        if options.whole and not options.pretty:
            headers["etag"] = tag
        # A conversion looks through the motion before its first block, and says then what the target cannot hold.
        content = chain((next(export.content, b""),), export.content)
        if export.notices:
            text = " | ".join(notice.what for notice in export.notices)
            headers["x-mcml-notices"] = text.encode("ascii", "replace").decode()[:4000]
        return content, export.media_type, headers

    return streamed(database, make)
