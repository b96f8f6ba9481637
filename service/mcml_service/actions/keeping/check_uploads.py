"""Numbers of documents compared with the files they came from, which are read again."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from mcml.errors import FormatError, McmlError, NotFoundError
from mcml.files.clip_files import Clip
from mcml.files.import_options import ImportOptions
from mcml.files.open_clip import open_clip
from mcml.formats import FORMATS
from mcml.formats.format import SourceFile
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.skeleton import Array
from mcml_service.actions.exporting.export_motion import skeleton_file
from mcml_service.clips.read_clip import read_clip
from mcml_service.settings import Settings
from mcml_service.storage.core.schema import CHUNK
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.encoding import join_blocks
from mcml_service.storage.transaction import Transaction


@dataclass(frozen=True)
class Compared:
    """A document compared with its files.

    key: of the document. faults: places where its first revision has other numbers. chunks: (chunk, bone) of tracks
    with differences. unread: the reason if its files could not be compared.
    """

    key: int
    name: str
    faults: tuple[str, ...] = ()
    chunks: tuple[tuple[int, int], ...] = ()
    unread: str | None = None


def compare_all(tx: Transaction, settings: Settings) -> Iterator[Compared]:
    """Compare every document that has an upload with it, including deleted ones."""
    for key, uuid, name in tx.documents.everything():
        label = f"{name} ({uuid})"
        try:
            yield _compare(tx, key, uuid, label, settings)
        # Any error from damaged rows is reported as a fault, not as a traceback.
        except Exception as error:
            reason = str(error) if isinstance(error, McmlError) else "its rows cannot be read"
            yield Compared(key, label, faults=(reason,))


def _compare(tx: Transaction, key: int, uuid: str, label: str, settings: Settings) -> Compared:
    try:
        then = tx.at_commit(tx.documents.commit_of(key, 1))
    except NotFoundError as pruned:
        return Compared(key, label, unread=str(pruned))
    stored = then.documents.get(uuid, deleted=True)
    held = read_clip(then, stored, labelled=False).clip
    try:
        kept = _open_upload(then, stored, held, settings)
        if kept is None:
            return Compared(key, label)
        return _differences(key, label, kept.blocks(), held.blocks(), held.head.skeleton.names)
    except FormatError as error:
        return Compared(key, label, unread=str(error))


def _open_upload(tx: Transaction, stored: StoredDocument, held: ClipStream, settings: Settings) -> ClipStream | None:
    """The clip in the kept files, None where none are kept."""
    files = {}
    for upload in tx.uploads.of(stored.key):
        content = tx.uploads.read(stored.key, upload.part) or ()
        files[upload.part] = SourceFile(upload.file_name, io.BytesIO(b"".join(content)))
    if not files:
        return None
    if stored.format == "asf-amc" and "asf" not in files:
        files = {"asf": skeleton_file(tx, stored), **files}
    encoding = next((part.encoding for part in held.head.sources if part.encoding != "utf-8"), None)
    rate = held.head.fields.get("dataframe_rate") if stored.format not in FORMATS else None
    options = ImportOptions(encoding=encoding, rate=None if rate is None else float(rate))
    return open_clip(Clip.of_kept(stored.format, files), options, settings.file_limits).stream


def _differences(
    key: int, label: str, given: Iterable[FrameBlock], wanted: Iterable[FrameBlock], names: Sequence[str]
) -> Compared:
    faults: dict[str, None] = {}
    chunks: dict[tuple[int, int], None] = {}
    for chunk, (first_side, other_side) in enumerate(zip_longest(_chunks(given), _chunks(wanted))):
        both = [side for side in (first_side, other_side) if side is not None]
        columns = tuple(dict.fromkeys(column for side in both for column in side.columns))
        first_values, other = _spread(first_side, columns), _spread(other_side, columns)
        if len(first_values) != len(other):
            faults["it has another number of frames than its file"] = None
            break
        different = ~(
            (first_values == other) & (np.signbit(first_values) == np.signbit(other))
            | np.isnan(first_values) & np.isnan(other)
        )
        for index in np.flatnonzero(different.any(axis=0)).tolist():
            rows = np.flatnonzero(different[:, index])
            first, last = chunk * CHUNK + int(rows[0]) + 1, chunk * CHUNK + int(rows[-1]) + 1
            bone = columns[index][0]
            faults[f"bone {names[bone]!r}, frames {first} to {last}: other numbers than in its file"] = None
            chunks[chunk, bone] = None
    return Compared(key, label, tuple(faults), tuple(chunks))


def _chunks(blocks: Iterable[FrameBlock]) -> Iterator[FrameBlock]:
    """The samples of CHUNK frames at a time."""
    waiting: list[FrameBlock] = []
    for block in blocks:
        waiting.append(block)
        while sum(map(len, waiting)) >= CHUNK:
            values, columns = join_blocks(waiting)
            yield FrameBlock(values[:CHUNK], columns, (), [])
            waiting = [FrameBlock(values[CHUNK:], columns, (), [])]
    if sum(map(len, waiting)):
        yield FrameBlock(*join_blocks(waiting), (), [])


def _spread(block: FrameBlock | None, columns: tuple[tuple[int, int], ...]) -> Array:
    """Return the samples in these columns, NaN where missing."""
    if block is None:
        return np.empty((0, len(columns)))
    values = np.full((len(block), len(columns)), np.nan)
    values[:, [columns.index(column) for column in block.columns]] = block.values
    return values
