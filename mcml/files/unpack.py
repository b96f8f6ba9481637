"""Archives among uploaded files: zip, 7z, tar and gzip, also within each other, unpacked within limits."""

from __future__ import annotations

import gzip
import lzma
import posixpath
import struct
import tarfile
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from io import SEEK_END
from typing import IO, BinaryIO, Final, cast

from mcml.errors import FormatError, LimitError, McmlError, Place, SpaceError, is_full
from mcml.files.limits import FileLimits
from mcml.files.members_7z import Member, read_members
from mcml.files.zip_names import codec_of, member_names
from mcml.formats import READERS
from mcml.formats.format import SourceFile
from mcml.formats.zip_entries import header_of_first_entry

COPY_BYTES: Final = 1 << 20
MOST_DEPTH: Final = 3
"""Archives within each other: a tar in a gzip is two."""

# Errors of the libraries for bytes that are not an archive; names that are not UTF-8 give a ValueError.
_BROKEN = (
    *(zipfile.BadZipFile, tarfile.TarError, zlib.error, lzma.LZMAError, struct.error),
    *(RuntimeError, ValueError, OSError, EOFError),
)
_TITLES = {"zip": "zip", "7z": "7z archive", "gz": "gzip file", "tar": "tar archive"}


@dataclass
class _Budget:
    """Counts of unpacked data: bytes of all files of a request, and files of one upload with all its archives."""

    limits: FileLimits
    files: int = 0
    size: int = 0

    def count(self, files: int, file: SourceFile) -> None:
        self.files += files
        if self.files > self.limits.archive_files:
            raise LimitError(
                f"The archive holds {self.files} files, the limit is {self.limits.archive_files}.",
                at=Place(file=file.name),
                remedy="Send it in parts.",
            )

    def spool(
        self, member: IO[bytes] | gzip.GzipFile | Member, compressed: int, name: str, file: SourceFile, stack: ExitStack
    ) -> BinaryIO:
        """Unpack a member. Sizes stated by archives may be false, so the bytes themselves are counted."""
        spool = cast(BinaryIO, stack.enter_context(tempfile.SpooledTemporaryFile(max_size=8 * COPY_BYTES)))  # noqa: SIM115  # the stack closes it
        size = 0
        while block := member.read(COPY_BYTES):
            size += len(block)
            self.size += len(block)
            most = COPY_BYTES + self.limits.archive_ratio * compressed
            if self.size > self.limits.size or size > most:
                raise LimitError(
                    f"{name} unpacks to more than the limits allow.",
                    at=Place(file=file.name, element=name),
                    remedy="Send the files themselves.",
                )
            spool.write(block)
        spool.seek(0)
        return spool


def unpacked(
    files: list[SourceFile], limits: FileLimits, stack: ExitStack, problems: list[tuple[str, McmlError]]
) -> Iterator[SourceFile]:
    """The files, and those in archives among them.

    problems: receives (file name, error) for files that cannot be unpacked.
    """
    budget = _Budget(limits)
    for file in files:
        budget.files = 0
        yield from _opened(file, budget, 0, stack, problems, inside=False)


def _opened(
    file: SourceFile,
    budget: _Budget,
    depth: int,
    stack: ExitStack,
    problems: list[tuple[str, McmlError]],
    *,
    inside: bool,
) -> Iterator[SourceFile]:
    """The file, or those in it. inside: whether it is a member of a zip or a tar."""
    kind = _kind(file)
    if kind is None:
        yield file
        return
    try:
        members = _members(kind, file, budget, depth, stack, inside=inside)
    except McmlError as error:
        problems.append((file.name, error))
        return
    except _BROKEN as error:
        if isinstance(error, OSError) and is_full(error):
            raise SpaceError from error
        what = f"The {_TITLES[kind]} is damaged or encrypted."
        remedy = "Zip the files again, unencrypted." if kind == "zip" else "Send the files themselves, or a zip."
        problems.append((file.name, FormatError(what, at=Place(file=file.name), remedy=remedy)))
        return
    for member in members:
        yield from _opened(member, budget, depth + 1, stack, problems, inside=inside or kind != "gz")


def _kind(file: SourceFile) -> str | None:
    file.stream.seek(0)
    head = file.stream.read(512)
    file.stream.seek(0)
    if head.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        return None if _is_format_in_zip(file.name, head) else "zip"
    if head.startswith(b"7z\xbc\xaf\x27\x1c"):
        return "7z"
    if head.startswith(b"\x1f\x8b"):
        return "gz"
    return "tar" if head[257:262] == b"ustar" else None


def _is_format_in_zip(name: str, head: bytes) -> bool:
    """Whether the zip is one file of a format, by the header of its first entry alone: an entry that is not compressed
    follows as text, perhaps of another format.
    """
    header = header_of_first_entry(head)
    return not name.lower().endswith(".zip") and any(reader.sniff("", header) for reader in READERS.values())


def _members(
    kind: str, file: SourceFile, budget: _Budget, depth: int, stack: ExitStack, *, inside: bool
) -> list[SourceFile]:
    if depth >= MOST_DEPTH:
        raise LimitError(
            f"Archives are nested more than {MOST_DEPTH} deep.",
            at=Place(file=file.name),
            remedy="Send the files themselves, or one zip of them.",
        )
    if kind == "gz":
        return [_ungzipped(file, budget, stack)]
    # Folders tell which skeleton belongs to which motion, so those of an archive within one are its own.
    folder = posixpath.splitext(file.name)[0] + "/" if inside else ""
    found = _OPENERS[kind](file, budget, stack, folder)
    if not found:
        raise FormatError(
            f"The {_TITLES[kind]} holds no files.", at=Place(file=file.name), remedy="Put the motion files into it."
        )
    return found


def _unzipped(file: SourceFile, budget: _Budget, stack: ExitStack, folder: str) -> list[SourceFile]:
    archive = stack.enter_context(zipfile.ZipFile(file.stream))
    paths, notices = member_names(archive.infolist())
    chosen = [info for info in archive.infolist() if not info.is_dir() and not _is_litter(paths[info.header_offset])]
    budget.count(len(chosen), file)
    members = []
    for info in chosen:
        name = paths[info.header_offset]
        with archive.open(info) as member:
            spool = budget.spool(member, info.compress_size, name, file, stack)
        members.append(SourceFile(folder + name, spool, notices))
    return members


def _untarred(file: SourceFile, budget: _Budget, stack: ExitStack, folder: str) -> list[SourceFile]:
    found: list[tuple[bytes, BinaryIO]] = []
    with tarfile.open(fileobj=file.stream, mode="r:", encoding="utf-8", errors="surrogateescape") as archive:
        for info in archive:
            raw = info.name.encode("utf-8", "surrogateescape")
            member = archive.extractfile(info) if info.isreg() else None
            if member is None or _is_litter(raw.decode("latin-1")):
                continue
            budget.count(1, file)
            shown = raw.decode("utf-8", "replace")
            found.append((raw, budget.spool(member, min(info.size, _size(file.stream)), shown, file, stack)))
    codec = codec_of(b"\n".join(raw for raw, _ in found))
    return [SourceFile(folder + raw.decode(codec, "replace").removeprefix("./"), spool) for raw, spool in found]


def _unpacked_7z(file: SourceFile, budget: _Budget, stack: ExitStack, folder: str) -> list[SourceFile]:
    limits = budget.limits
    most = max(0, limits.size - budget.size)
    chosen = [
        member
        for member in read_members(file, stack, members=limits.archive_files, size=most, ratio=limits.archive_ratio)
        if not _is_litter(member.name)
    ]
    budget.count(len(chosen), file)
    size = _size(file.stream)
    return [SourceFile(folder + member.name, budget.spool(member, size, member.name, file, stack)) for member in chosen]


_OPENERS: Final = {"zip": _unzipped, "tar": _untarred, "7z": _unpacked_7z}


def _ungzipped(file: SourceFile, budget: _Budget, stack: ExitStack) -> SourceFile:
    stem, extension = posixpath.splitext(file.name)
    name = {".gz": stem, ".tgz": f"{stem}.tar"}.get(extension.lower(), file.name)
    budget.count(1, file)
    size = _size(file.stream)
    with gzip.GzipFile(fileobj=file.stream, mode="rb") as member:
        return SourceFile(name, budget.spool(member, size, name, file, stack), file.notices)


def _size(stream: BinaryIO) -> int:
    place = stream.tell()
    size = stream.seek(0, SEEK_END)
    stream.seek(place)
    return size


def _is_litter(name: str) -> bool:
    return name.startswith("__MACOSX/") or posixpath.basename(name).startswith(".")
