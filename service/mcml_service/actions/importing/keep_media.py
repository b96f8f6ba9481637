"""Store reference video and audio: recognised by its first bytes, stored unchanged."""

from __future__ import annotations

import hashlib
import io
import re
from typing import BinaryIO

from mcml.errors import UnsupportedError
from mcml.files.check_names import file_name
from mcml.formats.format import SourceFile
from mcml_service.storage.database import Database
from mcml_service.storage.documents.media import StoredMedia
from mcml_service.storage.documents.uploads import BLOCK_BYTES, compress_block

TYPES = {
    "video/mp4": rb"....ftyp(?!M4A)",
    "audio/mp4": rb"....ftypM4A",
    "video/webm": rb"\x1aE\xdf\xa3",
    "audio/ogg": rb"OggS",
    "audio/wav": rb"RIFF....WAVE",
    "audio/flac": rb"fLaC",
    "audio/mpeg": rb"ID3|\xff[\xe0-\xff]",
}
"""Media types that browsers play, and how their files begin."""

BLOCKS_AT_A_TIME = 16
"""Of a file that are written in one transaction, so that others write in between."""


def media_type_of(beginning: bytes) -> str:
    """The type of a file that begins so. UnsupportedError for one that browsers do not play."""
    for name, pattern in TYPES.items():
        if re.match(pattern, beginning, re.DOTALL):
            return name
    raise UnsupportedError(
        "This is no video or audio that browsers play.", remedy="Send MP4, WebM, Ogg, WAV, FLAC or MP3."
    )


def _some(stream: BinaryIO) -> list[bytes]:
    """The next blocks of a file, none at its end."""
    blocks = (stream.read(BLOCK_BYTES) for _ in range(BLOCKS_AT_A_TIME))
    return [block for block in blocks if block]


def keep_media(database: Database, uuid: str, file: SourceFile, offset: float, author: str) -> StoredMedia:
    """Attach a file to a document, replacing an existing one.

    offset: position of the first frame in it, in seconds. Raises AccessError without the right, ConflictError if the
    project's quota is full.
    """
    stream = file.stream
    stream.seek(0)
    kind = media_type_of(stream.read(64))
    size, digest = stream.seek(0, io.SEEK_END), hashlib.sha256()
    stream.seek(0)
    while data := stream.read(BLOCK_BYTES):
        digest.update(data)
    sha256 = digest.hexdigest()
    with database.write(author) as tx:
        tx.documents.require(tx.documents.get(uuid).key)
        key = tx.uploads.find(sha256, size)
        made = tx.uploads.begin(sha256, size) if key is None else None
    if made is not None:
        stream.seek(0)
        number, key = 0, made
        while blocks := [compress_block(data) for data in _some(stream)]:
            with database.write(author) as tx:
                tx.uploads.add_blocks(made, number, blocks)
            number += len(blocks)
    assert key is not None
    with database.write(author) as tx:
        stored = tx.documents.get(uuid)
        if made is not None:
            tx.uploads.complete(made)
        tx.media.put(stored.key, key, file_name(file.name), kind, offset)
        media = tx.media.of(stored.key)
    assert media is not None
    return media
