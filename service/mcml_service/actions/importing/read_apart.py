"""A clip read, checked, encoded and compressed in another process than the one that stores it."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from typing import Any

from mcml.errors import McmlError, Notice
from mcml.files.clip_files import Clip
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.importing.encode_clip import EncodedClip, encode_clip
from mcml_service.actions.importing.keep_upload import PackedFile, pack_file
from mcml_service.settings import Settings
from mcml_service.storage.documents.encoding import ClipEncoder, TrackRow


@dataclass(frozen=True)
class SentPart:
    """A file of a clip on its way to another process."""

    name: str
    content: bytes
    notices: tuple[Notice, ...]


@dataclass(frozen=True)
class SentClip:
    """A clip on its way to another process. parts: its files, by part of the format."""

    format: str
    parts: dict[str, SentPart]
    options: ImportOptions
    take: str | None = None

    @classmethod
    def of(cls, clip: Clip, options: ImportOptions) -> SentClip:
        """A clip with the bytes of its files, whose positions stay."""
        parts = {part: SentPart(file.name, _content(file), file.notices) for part, file in clip.files.items()}
        return cls(clip.format, parts, options, clip.take)

    @property
    def size(self) -> int:
        """Bytes of the files."""
        return sum(len(part.content) for part in self.parts.values())


@dataclass(frozen=True)
class ReadApart:
    """The result of another process for a clip. encoded: the clip, or the error."""

    uploads: list[PackedFile]
    rows: list[TrackRow]
    encoded: EncodedClip | McmlError


def read_apart(sent: SentClip, settings: Settings) -> ReadApart | None:
    """Read, check, encode and compress a clip and its files.

    Return None for an unexpected error: the importer then reads the clip, meets the same error, and reports it.
    """
    files = {name: SourceFile(part.name, io.BytesIO(part.content), part.notices) for name, part in sent.parts.items()}
    rows: list[TrackRow] = []
    encoder = ClipEncoder(_Inline())

    def keep(chunks: Iterator[list[TrackRow]]) -> None:
        for chunk in chunks:
            rows.extend(chunk)

    try:
        clip = Clip(sent.format, files, sent.take)
        kept = zip(clip.kept_files, sent.parts.values(), strict=True)
        uploads = [pack_file(name, part.content) for name, part in kept]
        try:
            encoded = encode_clip(clip, sent.options, settings, encoder, keep)
        except McmlError as error:
            return ReadApart(uploads, [], error)
        keep(encoder.rest())
    except Exception:
        return None
    return ReadApart(uploads, rows, encoded)


def _content(file: SourceFile) -> bytes:
    place = file.stream.tell()
    file.stream.seek(0)
    content = file.stream.read()
    file.stream.seek(place)
    return content


class _Inline(Executor):
    """Does at once what it is given: the process has nothing else to do meanwhile."""

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """A future that is done. Raises what the call raises."""
        done: Future[Any] = Future()
        done.set_result(function(*args, **kwargs))
        return done
