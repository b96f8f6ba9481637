"""Processes that read the short clips of an import beside the one that stores them.

Reading holds Python's lock, so threads do not help. A process without threads forks in a few milliseconds, and its
workers find files, options and settings in the memory they inherit. A process with threads must not fork: a server has
workers that stay (`import_pool`).

They are not programs as those of `processes`: copies have nothing to start or to be sent, and nobody watches
them, for they run the readers that the importer runs itself, under the same limits. One that dies costs time alone, as
the importer reads its clips.
"""

from __future__ import annotations

import gc
import io
import multiprocessing
import os
import signal
import struct
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import islice
from multiprocessing.connection import Connection, wait
from typing import Any, cast

from mcml.errors import McmlError
from mcml.files.gather_files import Clip
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.importing.encode_clip import EncodedClip, encode_clip
from mcml_service.actions.importing.keep_upload import PackedFile, packed
from mcml_service.settings import Settings
from mcml_service.storage.documents.encoding import ClipEncoder, TrackRow

FEWEST_CLIPS = 8
"""For which workers are started: to read these takes several times as long as to fork."""

MOST_BYTES = 4 << 20
"""Of the files of a clip that a worker reads; larger ones stream into the store."""

AHEAD = 8
"""Clips of each worker that are handed out and not taken yet: bounds the memory of an import."""

PIPE_BYTES = 1 << 20
"""Of what a worker made, on its way to the importer. For more one needs a privilege on Linux."""

ROWS_UNSEARCHED = 50_000
"""Objects between two searches for cycles: at Python's own 700 they take a sixth of the importer's time."""

_NUMBER = struct.Struct("=I")


@dataclass(frozen=True)
class ReadApart:
    """What a worker made of a clip. encoded: the clip, or why there is none."""

    uploads: list[PackedFile]
    rows: list[TrackRow]
    encoded: EncodedClip | McmlError


@dataclass(frozen=True)
class Task:
    """A clip for a worker."""

    clip: Clip
    options: ImportOptions


class ImportWorkers:
    """Workers that read clips a little ahead of the importer, who takes what they made in the order of the clips."""

    def __init__(self, tasks: dict[int, Task]) -> None:
        self._tasks = tasks
        self._numbers = iter(tasks)
        self._pipes: list[Connection] = []
        self._to_do = -1
        self._made: dict[int, ReadApart | None] = {}

    def take(self, number: int) -> ReadApart | None:
        """What a worker made of this clip. None where the importer must read it itself."""
        if number not in self._tasks:
            return None
        while number not in self._made and self._pipes:
            for pipe in wait(self._pipes):
                self._receive(cast(Connection, pipe))
        if self._pipes:
            self._hand_out(1)
        return self._made.pop(number, None)

    def is_behind(self, number: int) -> bool:
        """Whether the importer would have to wait for this clip."""
        is_due = number in self._tasks and number not in self._made
        return is_due and bool(self._pipes) and not wait(self._pipes, 0)

    def _receive(self, pipe: Connection) -> None:
        try:
            number, made = pipe.recv()
        except (EOFError, OSError):
            # A worker was killed, nobody knows with which clip: whatever is not made yet is the importer's.
            self._part()
        else:
            self._made[number] = made

    def _hand_out(self, count: int) -> None:
        for number in islice(self._numbers, count):
            os.write(self._to_do, _NUMBER.pack(number))

    def _part(self) -> None:
        """Take no more from workers, who end when they notice."""
        for pipe in self._pipes:
            pipe.close()
        self._pipes = []

    @contextmanager
    def started(self, settings: Settings, processes: int) -> Iterator[None]:
        """As many workers, which end when the block does."""
        context = multiprocessing.get_context("fork")
        to_do, self._to_do = os.pipe()
        running = []
        # What there is already need not be searched for cycles while many rows come and go, nor these rows often.
        gc.freeze()
        searched = gc.get_threshold()
        gc.set_threshold(ROWS_UNSEARCHED, *searched[1:])
        try:
            # The first worker begins while the others are started.
            self._hand_out(AHEAD * processes)
            for _ in range(processes):
                here, there = context.Pipe(duplex=False)
                self._pipes.append(here)
                work = _Work(self._tasks, settings, to_do, there)
                worker = context.Process(target=work.run, args=(self._to_do, self._pipes), daemon=True)
                with there:
                    _widen(there)
                    # Where there is no room for another process, its pipe ends here.
                    with suppress(OSError):
                        worker.start()
                        running.append(worker)
            yield
        finally:
            gc.set_threshold(*searched)
            gc.unfreeze()
            self._part()
            for end in (to_do, self._to_do):
                os.close(end)
            for worker in running:
                worker.terminate()
            for worker in running:
                worker.join()


def may_fork() -> bool:
    """Whether nothing of this process would be left in the middle of its work in a copy of it."""
    # Frameworks of macOS start threads that Python does not know. Workers of a pool may have no children.
    is_alone = threading.active_count() == 1 and not multiprocessing.current_process().daemon
    return sys.platform == "linux" and is_alone


def _widen(pipe: Connection) -> None:
    import fcntl

    # Beyond what one user's pipes may hold together, the usual 64 KiB have to do.
    with suppress(OSError):
        fcntl.fcntl(pipe.fileno(), fcntl.F_SETPIPE_SZ, PIPE_BYTES)


@dataclass(frozen=True)
class _Work:
    """What a worker does. to_do: a pipe of numbers of tasks, from which all workers help themselves."""

    tasks: dict[int, Task]
    settings: Settings
    to_do: int
    answers: Connection

    def run(self, handing_out: int, taking: Sequence[Connection]) -> None:
        """Read clips until nobody hands them out or takes them. handing_out, taking: the importer's ends of pipes."""
        # As long as any process had these, no end of a pipe would tell that the importer was killed.
        os.close(handing_out)
        for pipe in taking:
            pipe.close()
        # A handler of the importer's, or the traceback of an interrupt, has no place here.
        for kind in (signal.SIGINT, signal.SIGTERM):
            signal.signal(kind, signal.SIG_DFL)
        # A search for cycles would copy the inherited memory, and finds hardly any; a worker ends with its call.
        gc.disable()
        with suppress(BrokenPipeError):
            while found := os.read(self.to_do, _NUMBER.size):
                (number,) = _NUMBER.unpack(found)
                self.answers.send((number, self._read(number)))

    def _read(self, number: int) -> ReadApart | None:
        try:
            return read_apart(self.tasks[number], self.settings)
        except Exception:
            # The importer meets the same, and says it in its own words.
            return None


def read_apart(task: Task, settings: Settings) -> ReadApart:
    """Read, check, encode and compress a clip and its files."""
    contents = {part: _content(file) for part, file in task.clip.files.items()}
    clip = Clip(
        task.clip.format,
        {part: replace(file, stream=io.BytesIO(contents[part])) for part, file in task.clip.files.items()},
    )
    uploads = [packed(part, content) for part, content in contents.items()]
    rows: list[TrackRow] = []
    encoder = ClipEncoder(_Inline())

    def keep(chunks: Iterator[list[TrackRow]]) -> None:
        for chunk in chunks:
            rows.extend(chunk)

    try:
        encoded = encode_clip(clip, task.options, settings, encoder, keep)
    except McmlError as error:
        return ReadApart(uploads, [], error)
    keep(encoder.rest())
    return ReadApart(uploads, rows, encoded)


def _content(file: SourceFile) -> bytes:
    """The bytes of a file, without moving the position that all who inherited it share."""
    stream = file.stream
    if getattr(stream, "name", None) is None:
        # It lies in memory, of which this process has a copy.
        stream.seek(0)
        return stream.read()
    size = os.fstat(stream.fileno()).st_size
    content = os.pread(stream.fileno(), size, 0)
    if len(content) != size:
        raise OSError(f"{file.name} was read in part")
    return content


class _Inline(Executor):
    """Does at once what it is given: a worker has nothing else to do meanwhile."""

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """A future that is done. Raises what the call raises."""
        done: Future[Any] = Future()
        done.set_result(function(*args, **kwargs))
        return done
