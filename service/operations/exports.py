"""Documents leaving the repository: MCML, and every format that can hold them."""

from __future__ import annotations

from itertools import chain
from typing import Annotated

from pydantic import Field

from schemas.examples import MCML
from schemas.exports import ExportRequest
from service.actions.exporting.export_motion import ExportOptions
from service.actions.exporting.export_motion import export_document as exported
from service.formats import FORMATS
from service.operations.arguments import AtRevision, DocumentId, First, Last, at_revision, tag
from service.operations.call import Call, Content
from service.operations.operation import gives

TYPES = [*(item.media_type for item in FORMATS.values()), "application/zip", "application/xml", "text/csv"]


@gives("The document", {"application/xml": MCML})
def get_mcml(
    call: Call,
    id: DocumentId,
    revision: AtRevision = None,
    pretty: Annotated[bool, Field(description="Every element on a line of its own")] = False,
    first: First = 1,
    last: Last = None,
) -> Content:
    options = ExportOptions("mcml", first=first, last=last, pretty=pretty)
    answer = _content(call, id, revision, options)
    answer.shown = True
    return answer


@gives(
    "The file: text in its own format, asf-amc a zip of both, mcml XML, csv a table of frames",
    dict.fromkeys(name.partition(";")[0] for name in TYPES),
)
def export_document(
    call: Call,
    id: DocumentId,
    format: Annotated[
        str, Field(description="bvh, asf-amc (a zip), asf, amc, htr, c3d, trc, mcml or csv", examples=["htr"])
    ],
    revision: AtRevision = None,
    first: First = 1,
    last: Last = None,
    names: Annotated[
        str | None,
        Field(description="Joint names: mcml, bvh1, bvh2, asf or htr; default the source's", examples=["mcml"]),
    ] = None,
    unit: Annotated[
        str | None, Field(description="Scale lengths to this unit; the document must state its own", examples=["mm"])
    ] = None,
    up: Annotated[str | None, Field(description="Turn so that this axis points up", examples=["Z"])] = None,
    original: Annotated[bool, Field(description="Answer the kept bytes of an unedited document")] = True,
) -> Content:
    """In its own format an unedited one comes back byte for byte."""
    return _content(call, id, revision, ExportOptions(format, first, last, names, unit, up, original=original))


@gives("A zip, made while it is sent; `refused.txt` in it says what could not be exported", {"application/zip": None})
def export_documents(call: Call, request: ExportRequest) -> Content:
    """Each document as it is now. Two of one name become two files, the second with the end of its id."""
    from service.actions.composing import export_documents as exporting

    options = ExportOptions(request.format, names=request.names, unit=request.unit, up=request.up)
    content = exporting.export_documents(call.database, call.queries, request.selection, options)
    return Content(content, "application/zip", f"{request.selection.project or 'documents'}.zip")


def _content(call: Call, uuid: str, revision: int | None, options: ExportOptions) -> Content:
    then, stored = at_revision(call.read(), uuid, revision)
    if options.whole and not options.pretty:
        call.tagged(tag(stored, options.format))
    export = exported(then, stored, options)
    # A conversion looks through the motion before its first block, and says then what the target cannot hold.
    content = chain((next(export.content, b""),), export.content)
    return Content(content, export.media_type, export.file_name, export.size, notices=export.notices)
