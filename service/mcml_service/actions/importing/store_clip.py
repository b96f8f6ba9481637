"""A clip that an analysis made, as a document."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np

from mcml.errors import McmlError, UnsupportedError
from mcml.files.check_names import given_name
from mcml.files.clip_files import Clip
from mcml.files.import_options import ImportOptions, Label
from mcml.files.open_clip import open_made
from mcml.files.targets import convert_clip
from mcml.formats import WRITERS
from mcml.formats.format import SourceFile
from mcml.language.elements import Element, from_head
from mcml.language.writer import write_document
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, Shape, full_shape
from mcml.motion.rotations import to_euler
from mcml.motion.skeleton import CHANNEL_INDEX, TRANSLATIONS, Array, Convention, numbers
from mcml.motion.units import UNITS
from mcml_service.actions.exporting.export_motion import file_stem
from mcml_service.actions.importing.import_clip import Importer
from mcml_service.actions.importing.keep_upload import WORKERS
from mcml_service.analysis.interface import MadeClip
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

UNIT_OF = {metres: unit for unit, metres in reversed(list(UNITS.items()))}
PROVENANCE = "provenance"
"""The property with the sources of a clip, as JSON."""


def store_clip(
    database: Database,
    made: MadeClip,
    settings: Settings,
    *,
    project: str,
    author: str,
    provenance: Mapping[str, Any],
    once: bool = False,
) -> str:
    """Store a made clip as a new document; see `store_stream`."""
    return store_stream(
        database,
        as_stream(made),
        settings,
        name=made.name,
        project=project,
        author=author,
        provenance=provenance,
        labels=tuple(Label(name, first + 1, last + 1) for name, first, last in made.labels),
        once=once,
    )


def store_stream(
    database: Database,
    stream: ClipStream,
    settings: Settings,
    *,
    name: str,
    project: str,
    author: str,
    provenance: Mapping[str, Any],
    labels: tuple[Label, ...] = (),
    once: bool = False,
) -> str:
    """Store a clip as a document with its provenance; return its uuid.

    once: use an existing document with the same bytes and provenance.
    """
    record = (PROVENANCE, json.dumps(provenance, ensure_ascii=False, separators=(",", ":")), "")
    kept = tuple(item for item in stream.head.properties if item[0] != PROVENANCE)
    frames = list(stream.blocks())
    head = replace(stream.head, properties=(*kept, record))
    stream = ClipStream(head, lambda: iter(frames), sum(map(len, frames)))
    document = from_head(head)
    clip = Clip("mcml", {"mcml": SourceFile("made.mcml", io.BytesIO(b"".join(_mcml(stream, document))))})
    options = ImportOptions(
        project=given_name(project, "project"),
        name=given_name(name, "document"),
        labels=labels,
        on_duplicate="skip" if once else "new",
    )
    with ThreadPoolExecutor(WORKERS) as executor:
        made = open_made(document, stream, settings.file_limits)
        importer = Importer(database, clip, options, settings, author, executor, None, made=made)
        importer.begin()
        stored = importer.read()
        if stored is None:
            importer.compress()
            importer.finish()
            stored = importer.store_alone()
    return stored.uuid


def clip_file(made: MadeClip, format_name: str) -> tuple[str, str, bytes]:
    """(file name, media type, bytes) of a made clip in a format of one file. UnsupportedError."""
    name = file_stem(made.name)
    if format_name == "mcml":
        stream = as_stream(made)
        return f"{name}.mcml", "application/xml", b"".join(_mcml(stream, from_head(stream.head)))
    known = WRITERS.get(format_name)
    if known is None or len(known.parts) != 1:
        singles = ", ".join(["mcml", *(item for item, writer in WRITERS.items() if len(writer.parts) == 1)])
        raise UnsupportedError(f"{format_name!r} is not a format of one file.", remedy=f"Use one of: {singles}.")
    clip = convert_clip(as_stream(made), format_name)
    part = known.parts[0]
    return f"{name}{part.extensions[0]}", known.media_type, b"".join(known.write(clip, part.name))


def _mcml(stream: ClipStream, document: Element) -> Iterator[bytes]:
    head = stream.head
    return write_document(document, stream.frames or 0, head.frame_time, stream.blocks(), head.skeleton.names)


def as_stream(made: MadeClip) -> ClipStream:
    """The clip in the channels of its skeleton: angles in degrees, continuous over the frames."""
    skeleton = made.skeleton
    columns = skeleton.columns()
    values = _values(made)
    fields = {"filename": f"{made.name}.mcml"}
    if made.metres is not None and made.metres in UNIT_OF:
        fields["calibration_unit"] = UNIT_OF[made.metres]
    if made.up:
        fields["global_axis_of_gravity"] = made.up
    marker = all(joint.convention is Convention.MARKER for joint in skeleton.joints)
    head = ClipHead(
        format="trc" if marker else "bvh",
        skeleton=skeleton,
        fields=fields,
        frame_time=repr(made.frame_time),
        description=made.description,
        properties=made.properties,
    )
    shapes, shape_of = _shapes(made, columns)

    def blocks() -> Iterator[FrameBlock]:
        yield FrameBlock(values, columns, shapes, np.arange(1, len(values) + 1), shape_of)

    return ClipStream(head, blocks, len(values))


def _values(made: MadeClip) -> Array:
    columns = made.skeleton.columns()
    values = np.zeros((len(made.rotations), len(columns)))
    place = {column: index for index, column in enumerate(columns)}
    for index, joint in enumerate(made.skeleton.joints):
        moved = made.translations[:, index]
        if joint.translation == "relative":
            moved = moved - numbers(joint.offset)
        for axis, channel in enumerate(TRANSLATIONS):
            if channel in joint.channels:
                values[:, place[index, CHANNEL_INDEX[channel]]] = moved[:, axis]
        letters = "".join(channel[1].upper() for channel in joint.channels if channel[0] == "R")
        if letters:
            # A joint with one or two angles is decomposed with the others last, where they become zero.
            angles = np.degrees(
                to_euler(made.rotations[:, index], letters + "".join(sorted(set("XYZ") - set(letters))))
            )
            for column, letter in enumerate(letters):
                values[:, place[index, CHANNEL_INDEX[f"R{letter.lower()}"]]] = angles[:, column]
    if made.present is not None:
        for column, (joint_index, _) in enumerate(columns):
            values[~made.present[:, joint_index], column] = np.nan
    if not np.isfinite(values[~np.isnan(values)]).all() or (made.present is None and np.isnan(values).any()):
        raise McmlError("The analysis made numbers that are not finite.", remedy="Report the result's parameters.")
    return values


def _shapes(made: MadeClip, columns: tuple[tuple[int, int], ...]) -> tuple[tuple[Shape, ...], Any]:
    whole = full_shape(columns)
    if made.present is None:
        return (whole,), None
    rows, shape_of = np.unique(made.present, axis=0, return_inverse=True)
    # A joint without sample stays in the frame by its name alone.
    shapes = tuple(tuple((joint, bits if row[joint] else 0) for joint, bits in whole) for row in rows)
    return shapes, shape_of.reshape(-1)
