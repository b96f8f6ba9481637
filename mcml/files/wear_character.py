"""A clip worn by the character of another file."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from mcml.errors import ConversionError, RequestError, UnsupportedError
from mcml.files.gather_files import gathered
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.open_clip import open_clip
from mcml.formats import READERS
from mcml.formats.format import CharacterReader, SourceFile
from mcml.language.elements import to_head
from mcml.motion.bodies.clip_body import body_of
from mcml.motion.characters.rigged import RiggedCharacter
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock
from mcml.motion.frames import joined, rows_of
from mcml.motion.retargeting.move_character import Movement, move_character
from mcml.motion.units import reading_of

OWN: Final = "own"
"""The name of this project's own figure, where a character is asked for."""
_REMEDY = "Take a GLB, glTF, VRM or FBX file with a skinned mesh."


def check_own(name: str) -> None:
    """Raises RequestError for any other name than that of the own figure."""
    if name != OWN:
        raise RequestError(f"{name!r} is no character.", remedy=f"Say {OWN}, or give a file with a skinned mesh.")


def wear_file(clip: ClipStream, file: SourceFile, limits: FileLimits) -> ClipStream:
    """Return the clip on the rig of a file's character, which it carries.

    Raises ConversionError where too few joints of the two are the same, UnsupportedError for files without a skinned
    mesh, and the errors of its reader.
    """
    head, block, rigged = _read_character(file, limits)
    source = _as_movement(clip.head, joined(clip.blocks()))
    seconds = clip.head.seconds_per_frame()
    if seconds is None:
        raise ConversionError("The clip states no frame time.", remedy="State it with `frame_time`.")
    return wear(clip, move_character(source, _as_movement(head, block), seconds).clip(), rigged)


def wear(clip: ClipStream, moved: ClipStream, rigged: RiggedCharacter) -> ClipStream:
    """Return a clip on the rig of a character with its mesh, and the notices of both clips and of the mesh."""
    rigged.check_skeleton(moved.head.skeleton, reading_of(moved.head))
    notices = clip.notices
    notices += [notice for notice in (*rigged.notices, *moved.notices) if notice not in notices]
    return replace(moved, notices=notices, character=rigged.character)


def _as_movement(head: ClipHead, block: FrameBlock) -> Movement:
    up = body_of(head, iter([block])).calibration.up
    return Movement(head, block, up.lstrip("-"))


def _read_character(file: SourceFile, limits: FileLimits) -> tuple[ClipHead, FrameBlock, RiggedCharacter]:
    """The head, the first frame and the character of a file."""
    options = ImportOptions()
    with gathered([file], limits, options=options) as found:
        for _, error in found.problems:
            raise error
        clip = found.clips[0]
        reader = READERS.get(clip.format)
        reading = options.for_reader(limits)
        rigged = reader.read_character(clip.files, reading) if isinstance(reader, CharacterReader) else None
        if rigged is None:
            raise UnsupportedError(f"{file.name!r} has no skinned mesh.", remedy=_REMEDY)
        opened = open_clip(clip, options, limits)
        head = to_head(opened.document, opened.stream.head.frame_time)
        block = rows_of(next(iter(opened.stream.blocks())), 0, 1)
    return head, block, rigged
