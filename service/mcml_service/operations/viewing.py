"""Data for drawing a document: its skeleton, and its thumbnail; and measures of its body."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from mcml.answers import Content
from mcml.errors import NotFoundError
from mcml_schemas.bodies import Calibration, CalibrationChange
from mcml_schemas.measurements import MeasurementFacts, MeasurementList
from mcml_schemas.skeletons import CharacterList, CharacterView, SkeletonView
from mcml_service.operations.arguments import (
    MOST,
    AtRevision,
    CharacterId,
    DocumentId,
    First,
    IfMatch,
    InProject,
    Last,
    Raw,
    at_revision,
    find_for_write,
    tag,
)
from mcml_service.operations.call import Call
from mcml_service.operations.operation import gives

if TYPE_CHECKING:
    pass

ANALOG_TYPES = {
    "csv": "text/csv",
    "arrow": "application/vnd.apache.arrow.stream",
    "parquet": "application/vnd.apache.parquet",
}
"""Media types of tables of analog channels, by form."""
THUMBNAIL = "application/vnd.mcml.thumbnail"


def get_skeleton(call: Call, id: DocumentId, revision: AtRevision = None) -> SkeletonView:
    """Bones with parents, sides, offsets, axes and channels; ends of chains; unit, up axis, rate and origin.

    With a `revision` the answer never changes and can be cached.
    """
    # Imported here: other operations need no mathematics.
    from mcml_service.actions.reading.describe_skeleton import describe_skeleton

    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        call.set_tag(tag(stored, "skeleton"), lasting=revision is not None)
        return describe_skeleton(then, stored)


def get_character(
    call: Call, id: DocumentId, revision: AtRevision = None, character: CharacterId = None
) -> CharacterView:
    """Without `character` the mesh is this project's own figure, to the lengths of the skeleton's bones.

    With it, it is the mesh of that document's file, on whose skeleton the motion is retargeted (docs/characters.md).
    A document that moves no such body has no mesh, and the answer has the reason. With a `revision` and without
    `character` the answer never changes and can be cached.
    """
    from mcml_service.actions.exporting.wear_character import At, describe_worn
    from mcml_service.actions.reading.describe_character import describe_character

    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        if character is None:
            call.set_tag(tag(stored, "character"), lasting=revision is not None)
            return describe_character(then, stored)
        worn = At(tx, tx.documents.get(character))
        call.set_tag(tag(stored, f"character-{worn.stored.uuid}-{worn.stored.revision}"))
        return describe_worn(At(then, stored), worn, call.repository.clips_on_characters)


def list_characters(call: Call, project: InProject = None) -> CharacterList:
    """A GLB, glTF, VRM or FBX file is a character if it has a mesh with a skin. Files with several takes are listed
    once.
    """
    from mcml_service.actions.reading import list_characters as listing

    with call.database.read() as tx:
        key = None if project is None else tx.projects.get(project)
        found, looked = listing.list_characters(tx, key)
    call.held.callback(listing.keep_vertices, call.database, looked)
    return found


def get_calibration(call: Call, id: DocumentId, revision: AtRevision = None) -> Calibration:
    """Each value has its origin: stated by the file, measured, guessed or set."""
    from mcml_service.actions.editing.calibration import describe_calibration

    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        return describe_calibration(then, stored)


def list_measurements(call: Call, id: DocumentId, revision: AtRevision = None) -> MeasurementList:
    """`GET /documents/{id}/frames?quantity=quantity:LKneeAngles,x` returns their values, and XPath asks for them.

    The values are those of the file: edits of the motion do not change them. Quantities of Plug-in Gait that it lacks
    are computed from the markers of the clip; their notes say how, and their reasons what is missing.
    """
    from mcml_service.clips.frame_quantities import read_measurements

    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        call.set_tag(tag(stored, "measurements"), lasting=revision is not None)
        return MeasurementList(
            items=[MeasurementFacts(**asdict(each)) for each in read_measurements(then, stored).describe()]
        )


@gives("The samples, as a table", dict.fromkeys(ANALOG_TYPES.values()))
def get_analog(
    call: Call,
    id: DocumentId,
    channel: Annotated[
        list[str] | None,
        Field(max_length=1000, description="Only these channels; may be repeated; default all", examples=[["EMG1"]]),
    ] = None,
    first: First = 1,
    last: Last = None,
    scaled: Annotated[
        bool, Field(description="In the unit of the channel; false: numbers as the file stores them", examples=[True])
    ] = True,
    format: Annotated[
        Literal["csv", "arrow", "parquet"],
        Field(description="arrow (an IPC stream) and parquet need the extra `arrow`", examples=["csv"]),
    ] = "csv",
    revision: AtRevision = None,
    raw: Raw = False,
) -> Content:
    """Columns: frame (a position from 1), time (seconds from the first frame), then a column for each channel. A frame
    has as many rows as samples. Samples follow the frames of the document; they are empty in frames that are not of
    the file. Units of columns are `unit` of the fields of `arrow` and `parquet`.
    """
    from mcml_service.actions.exporting.read_analog import read_analog
    from mcml_service.actions.exporting.write_tables import write_table

    then, stored = at_revision(call.read(), id, revision)
    end = stored.frames if last is None else min(last, stored.frames)
    batches, about = read_analog(then, stored, channel, first, end, scaled=scaled)
    content = write_table(format, batches, replace(about, raw=raw))
    return Content(content, ANALOG_TYPES[format], f"{stored.name}-analog.{format}")


def change_calibration(call: Call, id: DocumentId, change: CalibrationChange, if_match: IfMatch = None) -> Calibration:
    """Makes a revision. The unit and the up axis are those of the header, all else are properties of it."""
    from mcml_service.actions.editing.calibration import change_calibration as changed
    from mcml_service.actions.editing.calibration import describe_calibration

    with call.database.write(call.author) as tx:
        stored = changed(tx, find_for_write(tx, id, if_match), change)
        call.tag = tag(stored)
    with call.database.read() as tx:
        return describe_calibration(tx, tx.documents.get(id))


@gives("A moving picture of at most 4 KB, in the form MT1", {THUMBNAIL: None})
def get_thumbnail(
    call: Call,
    id: DocumentId,
    first: Annotated[
        int | None, Field(ge=1, le=MOST, description="Only frames from this one, a position from 1", examples=[1])
    ] = None,
    last: Last = None,
    revision: AtRevision = None,
) -> Content:
    """The busiest 2.6 seconds of the motion, and poses of the whole motion for scrubbing (docs/api/thumbnails.md).

    `first` and `last` show only these frames. 404 if a document has nothing to draw. With a `revision` the answer
    never changes and can be cached.
    """
    from mcml_service.actions.reading.make_thumbnail import read_range_thumbnail
    from mcml_service.actions.reading.show_thumbnails import keep_pictures, picture_of

    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        if first is not None or last is not None:
            start, end = first or 1, last or stored.frames
            call.set_tag(tag(stored, f"thumbnail-{start}-{end}"), lasting=revision is not None)
            drawn = read_range_thumbnail(then, stored, start, end)
            data = b"" if drawn is None else drawn.data
        else:
            call.set_tag(tag(stored, "thumbnail"), lasting=revision is not None)
            thumbnail = then.thumbnails.of([stored]).get(stored.key)
            if thumbnail is None:
                thumbnail = picture_of(then, stored)
                call.held.callback(keep_pictures, call.database, [(stored, thumbnail)])
            data = thumbnail.data
    if not data:
        raise NotFoundError(f"{stored.name!r} has no joints, so there is nothing to draw.", remedy="Look at its text.")
    return Content(iter([data]), THUMBNAIL, f"{stored.name}.mt1", size=len(data))
