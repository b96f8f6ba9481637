"""Why tracks: ways to lay frame_bone elements out in SQLite, on the same clips and questions in one run."""

from __future__ import annotations

import io
import os
import sqlite3
import statistics
import tempfile
import time
from abc import ABC, abstractmethod
from functools import partial
from pathlib import Path

import numpy as np
import zstandard

from benchmarks.library import clips, longer
from benchmarks.timing import median_seconds
from mcml.formats import FORMATS
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.skeleton import Array
from mcml_service.storage.documents.encoding import compress, decompress

CLIPS = 60
Motion = tuple[Array, list[slice]]
"""Values (F, D) of a clip, and the columns of each bone."""


class Layout(ABC):
    """One way. Clips are numbered from 0, frames and bones too; a range is first to last - 1."""

    name: str
    schema: str

    def __init__(self, path: Path, motions: list[Motion]) -> None:
        self.motions = motions
        self.database = sqlite3.connect(path)
        self.database.execute("PRAGMA journal_mode=WAL")
        self.database.execute(self.schema)
        with self.database:
            for number, (values, bones) in enumerate(motions):
                self.store(number, values, bones)

    @abstractmethod
    def store(self, clip: int, values: Array, bones: list[slice]) -> None: ...

    @abstractmethod
    def frames(self, clip: int, first: int, last: int) -> Array: ...

    @abstractmethod
    def above(self, bone: int, channel: int, bound: float) -> int:
        """How many frames of all clips have that channel of that bone above a bound."""

    @abstractmethod
    def edit(self, clip: int, frame: int, bone: int, value: float) -> int:
        """Set the first channel of a bone in a frame; answers the bytes of the rows written."""


class RowPerFrameBone(Layout):
    name = "row per frame_bone"
    schema = "CREATE TABLE t (clip INT, frame INT, bone INT, a, b, c, d, e, f, PRIMARY KEY (clip, frame, bone))"

    def store(self, clip: int, values: Array, bones: list[slice]) -> None:
        rows = []
        for bone, columns in enumerate(bones):
            part = values[:, columns].tolist()
            rows += [(clip, frame, bone, *row, *[None] * (6 - len(row))) for frame, row in enumerate(part)]
        self.database.executemany("INSERT INTO t VALUES (?,?,?,?,?,?,?,?,?)", rows)

    def frames(self, clip: int, first: int, last: int) -> Array:
        query = "SELECT a,b,c,d,e,f FROM t WHERE clip=? AND frame>=? AND frame<? ORDER BY frame, bone"
        rows = self.database.execute(query, (clip, first, last)).fetchall()
        flat = [value for row in rows for value in row if value is not None]
        return np.array(flat).reshape(last - first, -1)

    def above(self, bone: int, channel: int, bound: float) -> int:
        column = "abcdef"[channel]
        return int(
            self.database.execute(f"SELECT COUNT(*) FROM t WHERE bone=? AND {column}>?", (bone, bound)).fetchone()[0]
        )

    def edit(self, clip: int, frame: int, bone: int, value: float) -> int:
        with self.database:
            where = (value, clip, frame, bone)
            self.database.execute("UPDATE t SET a=? WHERE clip=? AND frame=? AND bone=?", where)
        return 6 * 9 + 12


class Chunks(Layout):
    """All bones of so many frames in one row."""

    schema = "CREATE TABLE t (clip INT, chunk INT, data BLOB, PRIMARY KEY (clip, chunk))"
    size = 256

    def pack(self, values: Array) -> bytes:
        return values.tobytes()

    def unpack(self, data: bytes, width: int) -> Array:
        return np.frombuffer(data).reshape(-1, width)

    def store(self, clip: int, values: Array, bones: list[slice]) -> None:
        rows = [
            (clip, start // self.size, self.pack(values[start : start + self.size]))
            for start in range(0, len(values), self.size)
        ]
        self.database.executemany("INSERT INTO t VALUES (?,?,?)", rows)

    def frames(self, clip: int, first: int, last: int) -> Array:
        width = self.motions[clip][0].shape[1]
        chunks = (clip, first // self.size, (last - 1) // self.size)
        rows = self.database.execute("SELECT data FROM t WHERE clip=? AND chunk>=? AND chunk<=? ORDER BY chunk", chunks)
        whole = np.concatenate([self.unpack(data, width) for (data,) in rows])
        start = first - first // self.size * self.size
        return whole[start : start + last - first]

    def above(self, bone: int, channel: int, bound: float) -> int:
        found = 0
        for clip, data in self.database.execute("SELECT clip, data FROM t"):
            values, bones = self.motions[clip]
            if bone < len(bones) and channel < bones[bone].stop - bones[bone].start:
                column = self.unpack(data, values.shape[1])[:, bones[bone].start + channel]
                found += int((column > bound).sum())
        return found

    def edit(self, clip: int, frame: int, bone: int, value: float) -> int:
        chunk, offset = divmod(frame, self.size)
        values, bones = self.motions[clip]
        (data,) = self.database.execute("SELECT data FROM t WHERE clip=? AND chunk=?", (clip, chunk)).fetchone()
        changed = self.unpack(data, values.shape[1]).copy()
        changed[offset, bones[bone].start] = value
        packed = self.pack(changed)
        with self.database:
            self.database.execute("UPDATE t SET data=? WHERE clip=? AND chunk=?", (packed, clip, chunk))
        return len(packed)


class RowPerFrame(Chunks):
    name = "row per frame"
    size = 1


class RawChunks(Chunks):
    name = "256 frames, all bones, raw"


class ShuffledChunks(Chunks):
    name = "256 frames, all bones, shuffled + zstd"

    def pack(self, values: Array) -> bytes:
        shuffled = np.ascontiguousarray(values.T).view(np.uint8).reshape(-1, 8).T
        return zstandard.compress(np.ascontiguousarray(shuffled).tobytes(), 3)

    def unpack(self, data: bytes, width: int) -> Array:
        raw = np.frombuffer(zstandard.decompress(data), np.uint8).reshape(8, -1).T
        return np.ascontiguousarray(raw).view(np.float64).reshape(width, -1).T


class Tracks(Layout):
    name = "track: one bone, 256 frames, pcodec, zones"
    schema = "CREATE TABLE t (clip INT, chunk INT, bone INT, low, high, data BLOB, PRIMARY KEY (clip, chunk, bone))"
    size = 256

    def store(self, clip: int, values: Array, bones: list[slice]) -> None:
        rows = []
        for start in range(0, len(values), self.size):
            turned = np.ascontiguousarray(values[start : start + self.size].T)
            for bone, columns in enumerate(bones):
                part = turned[columns]
                zones = part.min(axis=1).tobytes(), part.max(axis=1).tobytes()
                rows.append((clip, start // self.size, bone, *zones, compress(part)))
        self.database.executemany("INSERT INTO t VALUES (?,?,?,?,?,?)", rows)

    def frames(self, clip: int, first: int, last: int) -> Array:
        values, bones = self.motions[clip]
        base = first // self.size
        result = np.empty((values.shape[1], ((last - 1) // self.size - base + 1) * self.size))
        query = "SELECT chunk, bone, data FROM t WHERE clip=? AND chunk>=? AND chunk<=?"
        for chunk, bone, data in self.database.execute(query, (clip, base, (last - 1) // self.size)):
            part = decompress(data, bones[bone].stop - bones[bone].start, 1)
            result[bones[bone], (chunk - base) * self.size : (chunk - base) * self.size + part.shape[1]] = part
        start = first - base * self.size
        return result.T[start : start + last - first]

    def above(self, bone: int, channel: int, bound: float) -> int:
        found = 0
        for high, data in self.database.execute("SELECT high, data FROM t WHERE bone=?", (bone,)):
            width = len(high) // 8
            if channel < width and np.frombuffer(high)[channel] > bound:
                found += int((decompress(data, width, 1)[channel] > bound).sum())
        return found

    def edit(self, clip: int, frame: int, bone: int, value: float) -> int:
        chunk, offset = divmod(frame, self.size)
        columns = self.motions[clip][1][bone]
        where = (clip, chunk, bone)
        (data,) = self.database.execute("SELECT data FROM t WHERE clip=? AND chunk=? AND bone=?", where).fetchone()
        part = decompress(data, columns.stop - columns.start, 1).copy()
        part[0, offset] = value
        packed = compress(part)
        with self.database:
            self.database.execute("UPDATE t SET data=? WHERE clip=? AND chunk=? AND bone=?", (packed, *where))
        return len(packed)


class LongTracks(Tracks):
    name = "the same, 1,024 frames"
    size = 1024


LAYOUTS: tuple[type[Layout], ...] = (RowPerFrameBone, RowPerFrame, RawChunks, ShuffledChunks, Tracks, LongTracks)


def run() -> dict[str, object]:
    what, files = clips()
    files = longer(files[-CLIPS:], 5)
    text = sum(len(content) for _, content in files)
    motions = [_motion(content) for _, content in files]
    frames = sum(len(values) for values, _ in motions)
    print(f"   {len(files)} {what}, made five times as long: {text / 1e6:.0f} MB, {frames:,} frames")
    print(
        f"   {'layout':<44}{'bytes/BVH':>10}{'load s':>8}{'frames ms':>10}{'> x ms':>9}{'edit bytes':>11}{'clip ms':>9}"
    )
    bound = float(np.quantile(np.concatenate([values[:, bones[0].start + 1] for values, bones in motions]), 0.999))
    figures: dict[str, object] = {"what": what, "bytes": text}
    answers = set()
    with tempfile.TemporaryDirectory() as folder:
        for number, kind in enumerate(LAYOUTS):
            path = Path(folder) / f"{number}.db"
            start = time.perf_counter()
            layout = kind(path, motions)
            loading = time.perf_counter() - start
            layout.database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            size = os.path.getsize(path) / text
            longest = max(range(len(motions)), key=lambda clip: len(motions[clip][0]))
            part = median_seconds(partial(layout.frames, longest, 300, 343)) * 1e3
            whole = median_seconds(partial(layout.frames, longest, 0, len(motions[longest][0]))) * 1e3
            scan = median_seconds(partial(layout.above, 0, 1, bound), 3) * 1e3
            answers.add(layout.above(0, 1, bound))
            written = statistics.median(layout.edit(longest, 300 + n, 0, float(n)) for n in range(5))
            print(
                f"   {kind.name:<44}{size:>10.2f}{loading:>8.2f}{part:>10.2f}{scan:>9.2f}{written:>11.0f}{whole:>9.2f}"
            )
            figures[kind.name] = {
                "size": size,
                "load_s": loading,
                "frames_ms": part,
                "scan_ms": scan,
                "edit_bytes": written,
                "clip_ms": whole,
            }
            layout.database.close()
    if len(answers) != 1:
        raise RuntimeError(f"the layouts disagree: {answers}")
    return figures


def _motion(content: bytes) -> Motion:
    clip = FORMATS["bvh"].read({"bvh": SourceFile("clip.bvh", io.BytesIO(content))}, ReadOptions())
    bones: list[slice] = []
    start = 0
    for joint in clip.head.skeleton.joints:
        if joint.channels:
            bones.append(slice(start, start + len(joint.channels)))
            start += len(joint.channels)
    return np.concatenate([block.values for block in clip.blocks()]), bones
