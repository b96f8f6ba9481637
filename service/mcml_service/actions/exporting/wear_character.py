"""Stored clips worn by stored characters: documents whose kept file has a mesh with a skin."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace

from mcml.errors import ConversionError, DocumentError, LimitError
from mcml.files.clip_files import Clip
from mcml.files.wear_character import wear
from mcml.formats import READERS
from mcml.formats.format import CharacterReader, ReadOptions, SourceFile
from mcml.motion.characters.rigged import RiggedCharacter
from mcml.motion.clip import ClipStream
from mcml.motion.frames import joined
from mcml.motion.retargeting.move_character import MovedCharacter, Movement, check_size, move_character
from mcml.motion.units import reading_of
from mcml_schemas.skeletons import CharacterView
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.reading.describe_character import describe_mesh
from mcml_service.clips.bodies import read_up
from mcml_service.clips.read_clip import StoredClip, read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.library.cache import Cache

_REMEDY = "`GET /characters` lists the documents that have one; import a GLB, VRM or FBX file to add one."
_KEPT_BYTES = 64 << 20


@dataclass(frozen=True)
class At:
    """A document at a revision, and the transaction to read it with."""

    tx: Transaction
    stored: StoredDocument


def read_character(of: At) -> RiggedCharacter:
    """Read the character in the kept file of a document. Raises DocumentError where it has none."""
    uploads = of.tx.uploads.of(of.stored.key)
    files = {}
    for upload in uploads:
        stream = of.tx.uploads.open(of.stored.key, upload.part)
        if stream is not None:
            files[upload.part] = SourceFile(upload.file_name, stream)
    reader = READERS.get(of.stored.format)
    found = None
    if files and isinstance(reader, CharacterReader):
        clip = Clip.of_kept(of.stored.format, files)
        found = reader.read_character(clip.files, ReadOptions())
    if found is None:
        raise DocumentError(f"{of.stored.name!r} has no character: no file with a skinned mesh.", remedy=_REMEDY)
    return found


def move_clip(of: At, source: StoredClip, character: At) -> MovedCharacter:
    """Return frames of a document on the rig of a character. source: these frames.

    Raises what `move_character` does, and DocumentError for a document without a frame time.
    """
    body = read_clip(character.tx, character.stored, first=1, last=1, labelled=False)
    check_size(source.clip.frames or 0, len(source.clip.head.skeleton), len(body.clip.head.skeleton))
    moved, worn = (
        Movement(each.clip.head, joined(each.clip.blocks()), read_up(at.tx, at.stored, each.clip.head))
        for each, at in ((source, of), (body, character))
    )
    return move_character(moved, worn, seconds_of(of.stored))


def wear_stored(of: At, source: StoredClip, character: At) -> StoredClip:
    """Return frames of a document on the rig of a character, with its mesh, for an export."""
    moved = move_clip(of, source, character)
    clip = wear(source.clip, moved.clip(), read_character(character))
    return replace(source, clip=clip, names=clip.head.skeleton.names)


class MovedClips:
    """Whole documents on the rigs of characters, kept while there is room. Threads may share it, one works."""

    def __init__(self) -> None:
        self._kept = Cache[tuple[int, ...], MovedCharacter](_KEPT_BYTES, lambda moved: moved.block.values.nbytes)
        self._lock = threading.Lock()

    def read(self, of: At, character: At) -> MovedCharacter:
        """Return a whole document on the rig of a character. Raises as `move_clip` does."""
        key = (of.stored.key, of.stored.revision, character.stored.key, character.stored.revision)
        with self._lock:
            found = self._kept.find(key)
            if found is None:
                found = move_clip(of, read_clip(of.tx, of.stored, labelled=False), character)
                self._kept.put(key, found)
        return found

    def clip(self, of: At, character: At, first: int, last: int | None, step: int) -> StoredClip:
        """Return every step-th frame from first to last, positions from 1, on the rig of a character."""
        source = read_clip(of.tx, of.stored, first=first, last=last, step=step, labelled=False)
        moved = self.read(of, character)
        chosen = slice(source.first - 1, source.last, step)
        block = moved.block
        shape_of = None if block.shape_of is None else block.shape_of[chosen]
        rows = replace(block, values=block.values[chosen], ids=block.ids[chosen], shape_of=shape_of, motion_names=None)
        head = moved.head.every(step)
        clip = ClipStream(head, lambda: iter([rows]), len(rows), list(moved.notices))
        return replace(source, clip=clip, names=head.skeleton.names)


def describe_worn(of: At, character: At, moved: MovedClips) -> CharacterView:
    """Describe the mesh of a character as a document moves it, or say why it cannot."""
    try:
        made = read_character(character)
        head = read_clip(character.tx, character.stored, first=1, last=1, labelled=False).clip.head
        made.check_skeleton(head.skeleton, reading_of(head))
        found = moved.read(of, character)
    except (ConversionError, DocumentError, LimitError) as error:
        return CharacterView(reason=error.what, remedy=error.remedy)
    return CharacterView(
        mesh=describe_mesh(made.character),
        document=character.stored.uuid,
        revision=character.stored.revision,
        scale=found.scale,
        notes=[notice.what for notice in (*made.notices, *found.notices)],
    )
