"""Files of this machine: opened to be read, and written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from mcml.errors import ConflictError, UnsupportedError

if TYPE_CHECKING:
    from mcml.formats.format import SourceFile

Files: TypeAlias = str | PathLike[str] | Sequence[str | PathLike[str]]
"""A file, or several."""


def paths_of(files: Files) -> list[Path]:
    """One file or several as paths."""
    return [Path(files)] if isinstance(files, str | PathLike) else [Path(file) for file in files]


def name_of(path: Path) -> str:
    """Return the name of a file as text. Names on disk are bytes: UTF-8, or the encoding of an older system."""
    name = os.fsencode(path.name)
    for encoding in ("utf-8", "cp949"):
        with suppress(UnicodeDecodeError):
            return name.decode(encoding)
    return name.decode("latin-1")


@contextmanager
def opened_files(files: Files) -> Iterator[list[SourceFile]]:
    """Files to be read. UnsupportedError for one that cannot be opened."""
    # Imported late: code that only writes files needs no formats.
    from mcml.formats.format import SourceFile

    with ExitStack() as stack:
        found = []
        for path in paths_of(files):
            try:
                stream = stack.enter_context(path.open("rb"))
            except OSError as error:
                raise UnsupportedError(f"{path} cannot be read: {error.strerror}.") from error
            found.append(SourceFile(name_of(path), stream))
        yield found


@contextmanager
def opened_character(named: str | PathLike[str] | None) -> Iterator[SourceFile | str | None]:
    """The file of a character to be read; "own", the figure of this project, and None stay."""
    if named is None or named == "own":
        yield named if named is None else "own"
        return
    with opened_files(named) as (file,):
        yield file


def check_free(path: Path, *, force: bool = False, sources: Iterable[Path] = ()) -> None:
    """Raise ConflictError for an existing file that must not be replaced: any without force, an input file in any
    case.
    """
    if not path.exists():
        return
    if any(source.exists() and source.samefile(path) for source in sources):
        raise ConflictError(f"{path} is the file that is read.", remedy="Choose another name for the output.")
    if not force:
        raise ConflictError(f"{path} exists.", remedy="Choose another name; --force (in Python force) replaces it.")


def write_file(path: Path, blocks: Iterable[bytes | memoryview], *, force: bool = False) -> None:
    """The whole file or none: it gets its name when it is complete and on the disk. ConflictError: see check_free."""
    check_free(path, force=force)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as stream:
            for block in blocks:
                stream.write(block)
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
