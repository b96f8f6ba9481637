"""Documents leaving the repository: MCML, and every format that can hold them."""

from __future__ import annotations

from itertools import chain
from typing import Annotated, Literal

from pydantic import Field

from mcml.answers import Content
from mcml.errors import RequestError
from mcml.files.presets import Preset, find_preset
from mcml.formats import WRITERS
from mcml.language.writer import Layout
from mcml_schemas.elements import TextFound, TextPlace
from mcml_schemas.examples import MCML
from mcml_schemas.exports import ExportRequest
from mcml_schemas.frame_time import FrameTime
from mcml_service.actions.exporting.export_motion import ExportOptions
from mcml_service.actions.exporting.export_motion import export_document as exported
from mcml_service.actions.exporting.text_windows import find_text as find
from mcml_service.actions.exporting.text_windows import frames_window, head_window
from mcml_service.operations.arguments import (
    MOST,
    AtRevision,
    DocumentId,
    First,
    Fps,
    Guesses,
    Last,
    Raw,
    Scale,
    at_revision,
    tag,
)
from mcml_service.operations.call import Call
from mcml_service.operations.operation import gives

TYPES = [*(item.media_type for item in WRITERS.values()), "application/zip", "application/xml", "text/csv"]


@gives("The document", {"application/xml": MCML})
def get_mcml(
    call: Call,
    id: DocumentId,
    revision: AtRevision = None,
    pretty: Annotated[bool, Field(description="Every element on a line of its own")] = False,
    first: First = 1,
    last: Last = None,
    part: Annotated[
        Literal["head", "frames"] | None,
        Field(description="Only the lines before the first frame, or only those of frames first to last"),
    ] = None,
) -> Content:
    """For a part, the headers `x-mcml-first-line`, `x-mcml-lines` and `x-mcml-total-lines` give its lines in the whole
    text. With a `revision` the answer never changes and can be cached.
    """
    if part is not None:
        return _window(call, id, revision, part, first, last, Layout.PRETTY if pretty else Layout.LINES)
    options = ExportOptions("mcml", first=first, last=last, pretty=pretty)
    answer = _content(call, id, revision, options)
    answer.shown = True
    return answer


@gives(
    "The file in its own format; asf-amc a zip of both, mcml XML, csv a table of frames, glb and usd a scene",
    dict.fromkeys(name.partition(";")[0] for name in TYPES),
)
def export_document(
    call: Call,
    id: DocumentId,
    format: Annotated[
        str | None,
        Field(
            description="A format that `GET /formats` lists as written, a part of one (asf, amc), csv, or original: "
            "the uploaded file as it came; `for` decides it if it is missing",
            examples=["htr"],
        ),
    ] = None,
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
    original: Annotated[bool, Field(description="Return the original bytes of an unedited document")] = True,
    frame_time: Annotated[
        FrameTime | None,
        Field(
            description="Seconds a frame, where the document does not say, as 0.0083333 or 1/120",
            examples=["0.0083333"],
        ),
    ] = None,
    fps: Fps = None,
    scale: Scale = None,
    height: Annotated[
        float | None,
        Field(gt=0, le=100, description="Scale so that the body stands this many metres tall", examples=[1.75]),
    ] = None,
    in_place: Annotated[
        bool, Field(description="Keep the body over one place: without its way over the ground")
    ] = False,
    guesses: Guesses = True,
    character: Annotated[
        str | None,
        Field(
            description="glb and usd: a body with a skin instead of bones: `own`, of clips of a person; or the id of a "
            "document with a character, on whose skeleton the motion is retargeted",
            examples=["own"],
        ),
    ] = None,
    for_: Annotated[
        str | None,
        Field(
            alias="for",
            description="The program that reads the file, a preset of `GET /formats`; it decides format, unit and "
            "axes, other arguments win",
            examples=["blender"],
        ),
    ] = None,
    raw: Raw = False,
) -> Content:
    """In its own format an unedited one comes back byte for byte. `for` or `format` is required."""
    options = ExportOptions(
        format, first, last, names, unit, up, original=original, frame_time=frame_time, raw=raw, fps=fps, scale=scale,
        height=height, in_place=in_place, guesses=guesses, character=character, preset=_find_preset(for_, format),
    )  # fmt: skip
    return _content(call, id, revision, options)


@gives("A streamed zip; its `refused.txt` lists documents that could not be exported", {"application/zip": None})
def export_documents(call: Call, request: ExportRequest) -> Content:
    """Exports the current revision of each document.

    Two documents with the same name become two files, the second with the end of its id.
    """
    from mcml_service.actions.composing import export_documents as exporting

    options = ExportOptions(
        request.format or ("bvh" if request.for_ is None else None),
        names=request.names, unit=request.unit, up=request.up, frame_time=request.frame_time, raw=request.raw,
        fps=request.fps, scale=request.scale, height=request.height, in_place=request.in_place, guesses=request.guesses,
        character=request.character, preset=None if request.for_ is None else find_preset(request.for_),
    )  # fmt: skip
    content = exporting.export_documents(call.database, call.queries, request.selection, options)
    return Content(content, "application/zip", f"{request.selection.project or 'documents'}.zip")


def _find_preset(name: str | None, format: str | None) -> Preset | None:
    """Return a preset by its name. Raises RequestError if neither it nor a format is named."""
    if name is not None:
        return find_preset(name)
    if format is None:
        raise RequestError("No format is stated.", remedy="Say `format`, or `for` with the program that reads it.")
    return None


def _content(call: Call, uuid: str, revision: int | None, options: ExportOptions) -> Content:
    newest = call.read()
    then, stored = at_revision(newest, uuid, revision)
    if options.whole and not options.pretty:
        call.set_tag(tag(stored, f"{options.format}{'-raw' * options.raw}"))
    export = exported(then, stored, options, newest)
    # A conversion reads the whole motion before its first block, and then reports losses.
    content = chain((next(export.content, b""),), export.content)
    return Content(content, export.media_type, export.file_name, export.size, notices=export.notices)


def _window(
    call: Call, uuid: str, revision: int | None, part: str, first: int, last: int | None, layout: Layout
) -> Content:
    then, stored = at_revision(call.read(), uuid, revision)
    call.set_tag(tag(stored, f"mcml-{part}-{first}-{last}-{layout.value}"), lasting=revision is not None)
    if part == "head":
        window = head_window(then, stored, layout)
    else:
        window = frames_window(then, stored, first, stored.frames if last is None else last, layout)
    facts = {"first-line": window.first, "lines": window.lines, "total-lines": window.total}
    texts = {name: str(number) for name, number in facts.items()}
    return Content(window.content, "application/xml", f"{stored.name}.{part}.xml", facts=texts, shown=True)


def find_text(
    call: Call,
    id: DocumentId,
    text: Annotated[str, Field(min_length=1, max_length=1000, description="Text to find", examples=['Rx="45.'])],
    from_: Annotated[int, Field(alias="from", ge=1, le=MOST, description="Line to begin with", examples=[1])] = 1,
    revision: AtRevision = None,
    pretty: Annotated[bool, Field(description="In the text with every element on a line of its own")] = False,
) -> TextFound:
    """Searches the MCML text of the document, within lines.

    If a long document exceeds the time limit of queries, `next` is the line to continue from.
    """
    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        layout = Layout.PRETTY if pretty else Layout.LINES
        place, following = find(then, stored, text, from_, layout, call.settings.query_seconds)
    return TextFound(place=None if place is None else TextPlace(**vars(place)), next=following)
