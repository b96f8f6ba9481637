"""Frames as numbers: read as pages or one array, and set."""

from __future__ import annotations

import io
import math
import zlib
from collections.abc import Iterator
from functools import partial
from itertools import chain
from typing import Annotated, Any, Literal, cast
from urllib.parse import quote

import numpy as np
import orjson
from pydantic import Field, ValidationError

from mcml.answers import Content
from mcml.errors import DocumentError, RequestError
from mcml.files.read_numbers import Numbers, Space, chosen_bones, read_numbers
from mcml.motion.bodies.quantities import asked_quantity
from mcml.motion.skeleton import CHANNELS, Array
from mcml_schemas.documents import FramePage, FrameRow
from mcml_schemas.frames import FrameForm, FramesEdited, FrameValues
from mcml_service.actions.editing import frame_ranges
from mcml_service.actions.exporting.wear_character import At
from mcml_service.actions.exporting.write_tables import (
    TABLES,
    TYPES,
    About,
    npy_blocks,
    npy_header,
    npy_of,
    npz_blocks,
    plain_blocks,
    write_table,
)
from mcml_service.actions.reading.read_origin import origin_of
from mcml_service.actions.reading.read_quantities import quantity_columns, with_quantities
from mcml_service.actions.reading.reduce_frames import reduce_frames
from mcml_service.clips.frame_quantities import FrameQuantities
from mcml_service.clips.read_clip import StoredClip, read_clip
from mcml_service.operations.arguments import (
    MOST,
    AtRevision,
    CharacterId,
    DocumentId,
    First,
    IfMatch,
    Last,
    Page,
    Raw,
    at_revision,
    encode_cursor,
    find_for_write,
    tag,
)
from mcml_service.operations.call import Call
from mcml_service.operations.operation import Body, gives
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

MOST_IN_HEADER = 2048
"""Limit of the names of columns in a header, in bytes."""
ROWS = {"columns": ["left_up_leg.Rx"], "values": [[45.2], [45.9]]}
NPY = "a NumPy file of (frames, columns), the columns named by `column`"


@gives(
    "A page of frames; or with another `format` a file of all of them",
    {"application/octet-stream": None, **{TYPES[form]: None for form in ("block", *TABLES)}},
)
def get_frames(
    call: Call,
    id: DocumentId,
    page: Page,
    revision: AtRevision = None,
    first: First = 1,
    last: Last = None,
    step: Annotated[int, Field(ge=1, le=MOST, description="Every step-th frame, from `first` on", examples=[4])] = 1,
    bone: Annotated[
        list[str] | None,
        Field(
            description="Bones by MCML name; default: all, or none if quantities are given",
            examples=[["Root", "left_up_leg"]],
        ),
    ] = None,
    quantity: Annotated[
        list[str] | None,
        Field(
            max_length=100,
            description="Quantities of the body, as columns after those of bones: NAME:JOINT,JOINT or angle:NAME",
            examples=[["angle:left-knee-flexion", "speed:right_hand,Root"]],
        ),
    ] = None,
    space: Annotated[
        Space,
        Field(description="Source channels, or global joint positions (x y z) or rotations (x y z w) by kinematics"),
    ] = "channels",
    dtype: Annotated[Literal["f8", "f4"], Field(description="Numbers of the file")] = "f8",
    format: Annotated[
        FrameForm,
        Field(description="A page of JSON; or one array, arrays with their columns, numbers alone, a table"),
    ] = "json",
    origin: Annotated[
        Literal["keep", "subtract"],
        Field(description="subtract: positions relative to the document's origin, which is in a response header"),
    ] = "keep",
    missing: Annotated[
        Literal["hold", "nan"],
        Field(description="Positions and rotations that hang on a missing sample: as it was before, or NaN"),
    ] = "hold",
    tips: Annotated[
        bool, Field(description="After the bones' positions those of the ends of chains, as the skeleton lists them")
    ] = False,
    reduce: Annotated[
        Literal["minmax"] | None,
        Field(description="Channels: minimum and maximum of successive frame ranges"),
    ] = None,
    pixels: Annotated[
        int, Field(ge=1, le=100_000, description="Maximum number of frame ranges", examples=[800])
    ] = 1000,
    character: CharacterId = None,
    raw: Raw = False,
) -> FramePage | Content:
    """`npz` has `values`, `columns` (their names), `ids` and `times` (seconds from the first frame, NaN where the rate
    is unknown). Values of channels are (frames, columns), missing samples NaN; positions (frames, bones, 3), rotations
    (frames, bones, 4), bones in the order of `columns`. `npy` is `values` alone; a header names its columns if there
    are few. `block` is `npy` without its head: numbers alone, little-endian, frame after frame; the header
    `x-mcml-shape` has the lengths of its axes. `arrow` (an IPC stream) and `parquet` are tables of frame, id, time and
    a column for each channel, as is `csv`; the first two need the extra `arrow`. With a `revision` the answer never
    changes and can be cached.

    A `quantity` (docs/motion.md) is in metres, seconds and degrees, NaN where unknown: `height:left_hand`,
    `position:left_hand,up`, `angle:left-knee-flexion`, `speed:right_hand,Root`, `contact:left_toes` (1 or 0). The
    units of columns are `units` in `npz`, the header `x-mcml-units` of `npy` and `block`, and `unit` of the fields of
    `arrow` and `parquet`; those of channels are empty.

    With a `character` the numbers are those of its joints, on whose skeleton the motion is retargeted, in its unit and
    axes (docs/characters.md).

    `reduce=minmax` returns (ranges, columns, 2) as `npy` or `block`; the header `x-mcml-step` has the number of frames
    in each range (a multiple of 256 from 256 on, which needs no decompression).
    """
    if origin == "subtract" and (space != "positions" or format == "json"):
        raise RequestError("Only positions have an origin.", remedy="Ask with space=positions, in a format of numbers.")
    if tips and (space != "positions" or format == "json"):
        raise RequestError("Only positions have tips.", remedy="Ask with space=positions, in a format of numbers.")
    if quantity and (space != "channels" or format == "json" or reduce is not None):
        raise RequestError("Quantities stand beside channels.", remedy="Ask for another format, such as format=csv.")
    if character is not None and (quantity or format == "json" or reduce is not None or origin == "subtract"):
        raise RequestError(
            "A character has channels, positions and rotations alone.", remedy="Ask with format=block or npz."
        )
    if reduce is not None:
        if space != "channels" or format not in ("npy", "block") or step != 1:
            raise RequestError(
                "Extremes are those of channels, as npy or block.", remedy="Ask with format=block, without step."
            )
        return _reduce(call, id, revision, (first, last, pixels), bone, dtype, format)
    if format != "json":
        asked_for = [asked_quantity(name) for name in dict.fromkeys(quantity or ())]
        newest = call.read()
        then, stored = at_revision(newest, id, revision)
        worn = None if character is None else At(newest, newest.documents.get(character))
        asked = f"{space}-{dtype}-{zlib.crc32(repr((bone, quantity)).encode())}-{origin}-{missing}-{tips}-{raw}"
        asked += "" if worn is None else f"-{worn.stored.uuid}-{worn.stored.revision}"
        lasting = revision is not None and worn is None
        call.set_tag(tag(stored, f"{format}-{first}-{last}-{step}-{asked}"), lasting=lasting)
        if worn is None:
            source = read_clip(then, stored, first=first, last=last, step=step, labelled=False)
        else:
            source = call.repository.clips_on_characters.clip(At(then, stored), worn, first, last, step)
        point = origin_of(then, source) if origin == "subtract" else None
        numbers = read_numbers(source.clip, source.names, bone, space, origin=point, held=missing == "hold", tips=tips)
        if asked_for:
            # Cached together with the bodies for queries; a document has all data for reading a body.
            (body,) = call.queries.caches.bodies.read(then, [cast("Listed", stored)])
            quantities = FrameQuantities(then, stored, body)
            made = quantity_columns(quantities, asked_for, source.first, source.last)[::step]
            numbers = with_quantities(numbers, asked_for, quantities.units(asked_for), made, alone=not bone)
        content = _file(source, numbers, first, step, dtype, format, raw=raw)
        if point is not None:
            content.facts["origin"] = ",".join(map(repr, point.tolist()))
        return content
    after = page.after(int)
    start = first if after is None else int(after[0])
    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        call.lasting = revision is not None
        limit = stored.frames if last is None else last
        end = min(limit, start + (page.most(call) - 1) * step)
        source = read_clip(then, stored, first=start, last=end, step=step, labelled=False)
        wanted = chosen_bones(source.names, bone)
        items: list[FrameRow] = []
        for block in source.clip.blocks():
            for row, frame_id in zip(block.values.tolist(), block.ids, strict=True):
                values: dict[str, dict[str, float]] = {}
                for (number, channel), value in zip(block.columns, row, strict=True):
                    if number in wanted and value == value:
                        values.setdefault(source.names[number], {})[CHANNELS[channel]] = value
                items.append(FrameRow(frame=start + len(items) * step, id=str(frame_id), values=values))
    following = start + len(items) * step
    return FramePage(items=items, next_cursor=encode_cursor(following) if following <= limit else None)


def _reduce(
    call: Call,
    uuid: str,
    revision: int | None,
    which: tuple[int, int | None, int],
    bone: list[str] | None,
    dtype: str,
    form: str,
) -> Content:
    """which: first frame, last frame, ranges."""
    with call.database.read() as tx:
        then, stored = at_revision(tx, uuid, revision)
        asked = zlib.crc32(repr(bone).encode())
        call.set_tag(
            tag(stored, f"minmax-{form}-{'-'.join(map(str, which))}-{dtype}-{asked}"), lasting=revision is not None
        )
        reduced = reduce_frames(then, stored, *which, bone)
    shape = reduced.values.shape
    blocks = iter([reduced.values])
    content = npy_blocks(blocks, shape, dtype) if form == "npy" else plain_blocks(blocks, dtype)
    facts = _short(reduced.columns) | {"shape": ",".join(map(str, shape)), "step": str(reduced.step)}
    return Content(content, TYPES[form], facts=facts)


def _file(source: StoredClip, numbers: Numbers, first: int, step: int, dtype: str, form: str, *, raw: bool) -> Content:
    frames = source.clip.frames or 0
    shape = (frames, *numbers.shape)
    seconds = source.clip.head.seconds_per_frame()
    seconds = math.nan if seconds is None else seconds
    name = f"{source.stored.name}.{form}"
    if form == "npy":
        size = len(npy_header(shape, dtype)) + math.prod(shape) * np.dtype(dtype).itemsize
        values: Iterator[bytes | memoryview] = npy_blocks((block for block, _ in numbers.blocks()), shape, dtype)
        return Content(values, TYPES[form], name, size=size, facts=_describe_columns(numbers))
    if form == "block":
        values = plain_blocks((block for block, _ in numbers.blocks()), dtype)
        facts = _describe_columns(numbers) | {"shape": ",".join(map(str, shape))}
        return Content(values, TYPES[form], size=math.prod(shape) * np.dtype(dtype).itemsize, facts=facts)
    if form == "npz":
        ids: list[str] = []

        def values_then_ids() -> Iterator[Array]:
            for block, names in numbers.blocks():
                ids.extend(map(str, names))
                yield block

        arrays = {
            "values": lambda: npy_blocks(values_then_ids(), shape, dtype),
            "columns": lambda: npy_of(numbers.columns),
            "ids": lambda: npy_of(ids),
            "times": lambda: npy_of(np.arange(frames) * seconds),
        }
        if numbers.units is not None:
            arrays["units"] = partial(npy_of, numbers.units)
        return Content(npz_blocks(arrays), TYPES[form], name)

    # The quantity `time`, from frame 1, is not the time from the first frame of the table.
    columns = ["mo:time" if column == "time" else column for column in numbers.flat_columns]

    def batches() -> Iterator[dict[str, Any]]:
        done = 0
        for block, names in chain(numbers.blocks(), () if frames else ((np.empty((0, *numbers.shape)), []),)):
            places = np.arange(done, done + len(block))
            rows = block.reshape(len(block), len(columns)).astype(dtype)
            yield {
                "frame": first + places * step,
                "id": list(map(str, names)),
                "time": places * seconds,
                **{column: rows[:, index] for index, column in enumerate(columns)},
            }
            done += len(block)

    units = {} if numbers.units is None else dict(zip(columns, numbers.units, strict=True))
    return Content(write_table(form, batches(), About(units=units, raw=raw)), TYPES[form], name)


def _describe_columns(numbers: Numbers) -> dict[str, str]:
    """The names of columns, and their units where some are quantities."""
    names = _short(numbers.columns)
    return names if numbers.units is None or not names else names | {"units": ",".join(numbers.units)}


def _short(columns: list[str]) -> dict[str, str]:
    """Return the header with names of columns, percent-encoded, if there are few: proxies refuse long headers."""
    text = ",".join(quote(column, safe=" .:-_") for column in columns)
    return {"columns": text} if len(text) <= MOST_IN_HEADER else {}


def put_frames(
    call: Call,
    id: DocumentId,
    content: Annotated[
        bytes,
        Body({"application/json": ROWS, "application/octet-stream": NPY}, most=256 << 20, model=FrameValues),
        Field(description="JSON {columns, values}; or a NumPy file of (frames, columns), the columns named"),
    ],
    first: Annotated[int, Field(ge=1, le=MOST, description="Frame of the first row", examples=[100])] = 1,
    last: Annotated[
        int | None, Field(ge=1, le=MOST, description="Frame of the last row; so many rows are needed", examples=[142])
    ] = None,
    column: Annotated[
        list[str] | None,
        Field(description="BONE.CHANNEL of each column of an array", examples=[["left_up_leg.Rx"]]),
    ] = None,
    bone: Annotated[
        list[str] | None, Field(description="Or bones, each with every `channel`", examples=[["left_up_leg"]])
    ] = None,
    channel: Annotated[list[str] | None, Field(description="Channels of every `bone`", examples=[["Rx"]])] = None,
    if_match: IfMatch = None,
) -> FramesEdited:
    """Only changed tracks are written.

    Columns are named by `column`, or by `bone` and `channel`, which may be repeated: all channels of the first bone,
    then those of the next. JSON is `{columns, values}`, or a list of numbers or rows if the query names the columns.
    """
    stated = [*(column or []), *(f"{joint}.{other}" for joint in bone or [] for other in channel or [])]
    plain = call.media_type in ("", "application/json") and not content.startswith(b"\x93NUMPY")
    columns, values = _from_json(content, stated) if plain else (stated, _from_npy(content))
    if last is not None and last < first:
        raise DocumentError(
            f"The last frame, {last}, comes before the first, {first}.", remedy="Both ends are included."
        )
    if last is not None and len(values) != last - first + 1:
        raise DocumentError(
            f"Frames {first} to {last} need {last - first + 1} rows, there are {len(values)}.",
            remedy="Send a row for each frame, or leave `last` out.",
        )
    if values.shape[1] != len(columns):
        raise DocumentError(
            f"The array has {values.shape[1]} columns, {len(columns)} are named.", remedy="Name each: BONE.CHANNEL."
        )
    named = [(text.rpartition(".")[0], text.rpartition(".")[2]) for text in columns]
    with call.database.write(call.author) as tx:
        changed = _put(tx, find_for_write(tx, id, if_match), first, named, values)
    call.tag = tag(changed)
    return FramesEdited(revision=changed.revision, frames=changed.frames)


def _put(
    tx: Transaction, stored: StoredDocument, first: int, columns: list[tuple[str, str]], values: Array
) -> StoredDocument:
    if frame_ranges.write_values(tx, stored, first, columns, values):
        names = ", ".join(".".join(column) for column in columns[:4])
        tx.documents.add_revision(stored, "frames", f"set {names} of frames {first} to {first + len(values) - 1}")
    return tx.documents.get(stored.uuid)


def _from_json(content: bytes, stated: list[str]) -> tuple[list[str], Array]:
    """Columns and values. stated: the columns, where the body has numbers alone."""
    try:
        sent = orjson.loads(content or b"{}")
        if isinstance(sent, list):
            rows = sent if sent and isinstance(sent[0], list) else [[number] for number in sent]
            sent = {"columns": stated, "values": rows}
        values = FrameValues.model_validate(sent)
    except ValidationError as error:
        fault = error.errors()[0]
        raise _unread(f"{'.'.join(str(part) for part in fault['loc'])}: {fault['msg']}") from error
    except ValueError as error:
        raise _unread("the body is no JSON") from error
    if len({len(row) for row in values.values}) > 1:
        raise _unread("the rows have different lengths")
    return values.columns, np.array(values.values, dtype=np.float64)


def _unread(what: str) -> DocumentError:
    return DocumentError(f"The numbers cannot be read: {what}.", remedy="Send {columns, values}.")


def _from_npy(content: bytes) -> Array:
    try:
        values = np.load(io.BytesIO(content), allow_pickle=False)
        numbers: Array = np.ascontiguousarray(values, dtype=np.float64)
    except (ValueError, OSError, EOFError, TypeError) as error:
        raise DocumentError(
            "The array cannot be read.", remedy="Send what numpy.save writes, numbers of (frames, columns)."
        ) from error
    if numbers.ndim == 1:
        numbers = numbers[:, None]
    if numbers.ndim != 2 or not len(numbers):
        raise DocumentError(f"The array has the shape {values.shape}.", remedy="Send (frames, columns).")
    return numbers
