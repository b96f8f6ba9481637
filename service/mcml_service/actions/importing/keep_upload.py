"""A file on its way into the store, compressed while its motion is read."""

from __future__ import annotations

import hashlib
import io
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

from mcml.errors import NotFoundError, Place
from mcml.files.check_names import file_name
from mcml.formats import READERS
from mcml.formats.format import CharacterReader, SourceFile
from mcml_service.storage.documents.uploads import BLOCK_BYTES, compress_block
from mcml_service.storage.transaction import Transaction

EARLY_BYTES = 64 << 20
"""Files up to this size are compressed while they are read; larger ones block by block afterwards."""

WORKERS = 2


@dataclass(frozen=True)
class PackedFile:
    """A whole file as the store keeps it. blocks: compressed."""

    part: str
    size: int
    sha256: str
    blocks: list[bytes]


def pack_file(part: str, content: bytes) -> PackedFile:
    """A file that fits in memory, compressed."""
    blocks = [content[start : start + BLOCK_BYTES] for start in range(0, len(content), BLOCK_BYTES)]
    return PackedFile(part, len(content), _digest_of(blocks), [compress_block(block) for block in blocks])


@dataclass
class Upload:
    """A file on its way into the store.

    blocks: compressed, waiting for the last transaction; None where the store had its bytes already.
    early: blocks that are compressed while the motion is read, for files whose blocks all fit in memory.
    digest: waits for the SHA-256 of the file, which is taken meanwhile too. vertices: of its skinned meshes, None
    where nobody has looked.
    """

    part: str
    file: SourceFile
    size: int
    early: list[Future[bytes]]
    digest: Callable[[], str]
    blocks: list[bytes] | None = None
    key: int | None = None
    written: int = 0
    vertices: Callable[[], int | None] = lambda: None

    @classmethod
    def begin(cls, part: str, file: SourceFile, executor: ThreadPoolExecutor) -> Upload:
        """Read the file once, for its digest, and let its blocks be compressed where they all fit in memory."""
        size = file.stream.seek(0, os.SEEK_END)
        if size > EARLY_BYTES:
            sha256 = digest_of(file)
            return cls(part, file, size, [], lambda: sha256)
        blocks = list(_blocks_of(file))
        early = [executor.submit(compress_block, block) for block in blocks]
        made = cls(part, file, size, early, executor.submit(_digest_of, blocks).result)
        reader = READERS.get(part.partition("#")[0])
        if isinstance(reader, CharacterReader):
            made.vertices = executor.submit(reader.count_vertices, io.BytesIO(b"".join(blocks))).result
        return made

    @classmethod
    def of_packed(cls, file: SourceFile, made: PackedFile) -> Upload:
        """A file that was compressed elsewhere."""
        upload = cls(made.part, file, made.size, [], lambda: made.sha256, made.blocks)
        reader = READERS.get(made.part.partition("#")[0])
        if isinstance(reader, CharacterReader):
            vertices = reader.count_vertices(file.stream)
            file.stream.seek(0)
            upload.vertices = lambda: vertices
        return upload

    @property
    def sha256(self) -> str:
        return self.digest()

    def compress_blocks(self, executor: ThreadPoolExecutor) -> Iterator[bytes]:
        """The blocks in order, a few of them compressed ahead."""
        if self.early or not self.size:
            for job in self.early:
                yield job.result()
            return
        waiting: deque[Future[bytes]] = deque()
        for block in _blocks_of(self.file):
            waiting.append(executor.submit(compress_block, block))
            if len(waiting) > 2 * WORKERS:
                yield waiting.popleft().result()
        for job in waiting:
            yield job.result()

    @property
    def file_name(self) -> str:
        return file_name(self.file.name)

    def add(self, tx: Transaction, blocks: list[bytes]) -> None:
        if self.key is None:
            self.key = tx.uploads.begin(self.sha256, self.size)
        tx.uploads.add_blocks(self.key, self.written, blocks)
        self.written += len(blocks)

    def attach(self, tx: Transaction, document_key: int) -> bool:
        """Make it a file of the document, whole; answers whether its bytes were stored already."""
        # An equal file may have been stored since this one was read, by another import or earlier in this transaction.
        upload = tx.uploads.find(self.sha256, self.size) if self.key is None else None
        if upload is not None:
            tx.uploads.attach(document_key, self.part, self.file_name, upload)
            return True
        if self.blocks is None:
            raise NotFoundError(
                "The equal file that was stored has just been removed.",
                at=Place(file=self.file_name),
                remedy="Import the file again.",
            )
        if self.key is None:
            key = tx.uploads.add(self.sha256, self.size, self.blocks)
        else:
            key = self.key
            self.add(tx, self.blocks)
            tx.uploads.complete(key)
        tx.uploads.attach(document_key, self.part, self.file_name, key)
        vertices = self.vertices()
        if vertices is not None:
            tx.uploads.set_vertices(key, vertices)
        return False

    def abandon(self, tx: Transaction) -> None:
        """Drop what was written, after a failure."""
        if self.key is not None:
            tx.uploads.abandon(self.key)


def _blocks_of(file: SourceFile) -> Iterator[bytes]:
    file.stream.seek(0)
    while block := file.stream.read(BLOCK_BYTES):
        yield block
    file.stream.seek(0)


def digest_of(file: SourceFile) -> str:
    """The SHA-256 of a file."""
    return _digest_of(_blocks_of(file))


def _digest_of(blocks: Iterable[bytes]) -> str:
    hashed = hashlib.sha256()
    for block in blocks:
        hashed.update(block)
    return hashed.hexdigest()
