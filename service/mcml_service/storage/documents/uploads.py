"""The bytes of uploads, kept as they came: blocks of at most 1 MiB, compressed, equal files once."""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, BinaryIO, cast

import zstandard
from sqlalchemy import and_, bindparam, delete, func, or_, select, update

from mcml_service.storage.core.seals import verify
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import document, document_media, document_upload, upload, upload_block
from mcml_service.storage.core.transaction import BaseTransaction

BLOCK_BYTES = 1 << 20
LEASE_SECONDS = 120.0
"""How long an import may be silent before it counts as broken."""

# Made once: to build a statement takes four times as long as to run it.
_COMPLETE = Prepared(
    select(upload.c.id)
    .where(upload.c.sha256 == bindparam("sha256"), upload.c.size == bindparam("size"), upload.c.complete)
    .limit(1)
)
_RENEW = Prepared(update(upload).where(upload.c.id == bindparam("key")).values(lease=bindparam("until")))
_PARTS = document_upload.alias()
_MADE_OF = Prepared(
    select(document.c.uuid)
    .join(document_upload, document_upload.c.document == document.c.id)
    .join(upload, upload.c.id == document_upload.c.upload)
    .where(document_upload.c.part == bindparam("part"), upload.c.sha256 == bindparam("sha256"))
    # "+ 0": no index. Without statistics SQLite would begin with all documents of the project.
    .where(document.c.project + 0 == bindparam("project"), document.c.state == "ready")
    .where(document.c.deleted_commit > bindparam("at"))
    .where(
        select(func.count()).select_from(_PARTS).where(_PARTS.c.document == document.c.id).scalar_subquery()
        == bindparam("parts")
    )
)
_BLOCK = Prepared(
    select(upload_block.c.data).where(
        upload_block.c.upload == bindparam("key"), upload_block.c.number == bindparam("number")
    ),
    upload_block,
)
_MADE_COMPLETE = Prepared(update(upload).where(upload.c.id == bindparam("key")).values(complete=True, lease=None))


@dataclass(frozen=True)
class StoredUpload:
    """A kept file of a document. part: the format's part name."""

    part: str
    file_name: str
    size: int
    sha256: str


def compress_block(data: bytes) -> bytes:
    """Return the stored form of one block; thread-safe."""
    return _COMPRESSORS.one.compress(data)


class _Compressors(threading.local):
    """A compressor for each thread: its tables are too large to be allocated for each short file."""

    def __init__(self) -> None:
        self.one = zstandard.ZstdCompressor(level=1)


_COMPRESSORS = _Compressors()


@dataclass(frozen=True)
class StoredCharacter:
    """A document whose kept file has skinned meshes. document: its key. vertices: None: nobody has looked yet."""

    document: int
    part: str
    upload: int
    size: int
    vertices: int | None


class Uploads:
    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def find(self, sha256: str, size: int) -> int | None:
        """The key of the complete upload with these bytes, if it is kept already."""
        rows = self._tx.fetch_all(_COMPLETE, {"sha256": sha256, "size": size})
        return rows[0][0] if rows else None

    def add(self, sha256: str, size: int, blocks: list[bytes]) -> int:
        """Store a whole file at once, in compressed blocks, and answer its key."""
        key = self._tx.insert_row(upload, sha256=sha256, size=size, complete=True, lease=None)
        self._insert_blocks(key, 0, blocks)
        return key

    def begin(self, sha256: str, size: int) -> int:
        """Begin a file that is written in several transactions; `complete` it in the last one."""
        lease = time.time() + LEASE_SECONDS
        return self._tx.insert_row(upload, sha256=sha256, size=size, complete=False, lease=lease)

    def add_blocks(self, key: int, first: int, blocks: Iterable[bytes]) -> None:
        """Append compressed blocks, numbered from `first`, and renew the lease."""
        self._insert_blocks(key, first, blocks)
        self._tx.run(_RENEW, {"key": key, "until": time.time() + LEASE_SECONDS})

    def _insert_blocks(self, key: int, first: int, blocks: Iterable[bytes]) -> None:
        rows = [{"upload": key, "number": first + index, "data": data} for index, data in enumerate(blocks)]
        self._tx.insert_rows(upload_block, rows)

    def abandon(self, key: int) -> None:
        """Drop what an import that failed wrote of a file."""
        unfinished = select(upload.c.id).where(upload.c.id == key, ~upload.c.complete)
        self._tx.run(delete(upload_block).where(upload_block.c.upload.in_(unfinished)))
        self._tx.run(delete(upload).where(upload.c.id.in_(unfinished)))

    def complete(self, key: int) -> None:
        self._tx.run(_MADE_COMPLETE, {"key": key})

    def attach(self, document_key: int, part: str, file_name: str, key: int) -> None:
        row = {"document": document_key, "part": part, "file_name": file_name, "upload": key}
        self._tx.insert_rows(document_upload, [row])

    def of(self, document_key: int) -> list[StoredUpload]:
        query = (
            select(document_upload.c.part, document_upload.c.file_name, upload.c.size, upload.c.sha256)
            .join(upload, upload.c.id == document_upload.c.upload)
            .where(document_upload.c.document == document_key)
            .order_by(document_upload.c.part)
        )
        return [StoredUpload(*row) for row in self._tx.fetch_all(query)]

    def characters(self, kinds: Iterable[str]) -> list[StoredCharacter]:
        """Documents with a kept file that has skinned meshes, or may have some; in the order of keys.

        kinds: parts of files that can have them; of one of several takes, its name follows after `#`.
        """
        part = document_upload.c.part
        of_kind = or_(*((part == kind) | part.startswith(f"{kind}#") for kind in kinds))
        query = (
            select(document_upload.c.document, document_upload.c.part, upload.c.id, upload.c.size, upload.c.vertices)
            .join(upload, upload.c.id == document_upload.c.upload)
            .where(of_kind, upload.c.vertices.is_(None) | (upload.c.vertices > 0))
            .order_by(document_upload.c.document)
        )
        return [StoredCharacter(*row) for row in self._tx.fetch_all(query)]

    def set_vertices(self, key: int, vertices: int) -> None:
        """Keep how many vertices the skinned meshes of a file have."""
        self._tx.run(update(upload).where(upload.c.id == key).values(vertices=vertices))

    def twins(self, digests: dict[str, str], project_key: int) -> list[str]:
        """UUIDs of documents of the project, deleted ones aside, made from exactly these files ({part: sha256})."""
        self._tx.write_gathered()
        shared = {"project": project_key, "at": self._tx.at, "parts": len(digests)}
        candidates: set[str] | None = None
        for part, sha256 in digests.items():
            wanted = shared | {"part": part, "sha256": sha256}
            uuids = {uuid for (uuid,) in self._tx.fetch_all(_MADE_OF, wanted)}
            candidates = uuids if candidates is None else candidates & uuids
        return sorted(candidates or ())

    def read(self, document_key: int, part: str) -> Iterator[bytes] | None:
        """The bytes of a kept file in blocks, or None where it is not kept. DamageError where they are damaged."""
        key = self._find_part(document_key, part)
        return None if key is None else self.blocks(key)

    def open(self, document_key: int, part: str) -> BinaryIO | None:
        """A kept file, to be read anywhere as long as the transaction lasts; None where it is not kept."""
        key = self._find_part(document_key, part)
        if key is None:
            return None
        size = self._tx.fetch_column(select(upload.c.size).where(upload.c.id == key))[0]
        return cast("BinaryIO", io.BufferedReader(_KeptFile(self, key, size), BLOCK_BYTES))

    def _find_part(self, document_key: int, part: str) -> int | None:
        query = select(document_upload.c.upload).where(
            document_upload.c.document == document_key, document_upload.c.part == part
        )
        rows = self._tx.fetch_all(verify(query, document_upload))
        return rows[0][0] if rows else None

    def blocks(self, key: int, number: int = 0) -> Iterator[bytes]:
        """The bytes of an upload, block by block, from a block on."""
        while True:
            rows = self._tx.fetch_all(_BLOCK, {"key": key, "number": number})
            if not rows:
                return
            yield zstandard.ZstdDecompressor().decompress(rows[0][0], max_output_size=BLOCK_BYTES)
            number += 1

    def forget(self, document_key: int) -> None:
        """Drop the kept files of a document; exports are then written from the elements."""
        self._tx.run(delete(document_upload).where(document_upload.c.document == document_key))
        self.remove_orphans(0)

    def remove_orphans(self, lease_before: float) -> None:
        """Delete files that no document names and no running import holds."""
        orphan = and_(
            upload.c.id.not_in(select(document_upload.c.upload)), upload.c.id.not_in(select(document_media.c.upload))
        )
        query = select(upload.c.id).where(orphan, upload.c.complete | (upload.c.lease < lease_before))
        keys = self._tx.fetch_column(query)
        for key in keys:
            self._tx.run(delete(upload_block).where(upload_block.c.upload == key))
            self._tx.run(delete(upload).where(upload.c.id == key))


class _KeptFile(io.RawIOBase):
    """The bytes of an upload, one block in memory."""

    def __init__(self, uploads: Uploads, key: int, size: int) -> None:
        self._uploads, self._key, self._size = uploads, key, size
        self._place = 0
        self._block: tuple[int, bytes] = (-1, b"")

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self._place = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._place, io.SEEK_END: self._size}[whence]
        return self._place

    def readinto(self, buffer: Any) -> int:
        number, start = divmod(self._place, BLOCK_BYTES)
        if self._place >= self._size:
            return 0
        if self._block[0] != number:
            self._block = number, next(self._uploads.blocks(self._key, number), b"")
        data = self._block[1][start : start + len(buffer)]
        buffer[: len(data)] = data
        self._place += len(data)
        return len(data)
