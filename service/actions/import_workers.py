"""Processes that read the short clips of an import beside the one that stores them.

Reading holds Python's lock, so threads do not help. A process without threads forks in a few milliseconds, and its
workers find files, options and settings in the memory they inherit. A process with threads must not fork, and to start
a worker afresh takes longer than to read a hundred clips: there, and where fork is unsafe, the importer reads by itself.
"""

from __future__ import annotations

import gc
import io
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from service.actions.encode_clip import EncodedClip, TrackRows, encode_clip
from service.actions.gather_files import Clip
from service.actions.import_options import ImportOptions
from service.actions.keep_upload import PackedFile, packed
from service.errors import McmlError
from service.formats.format import SourceFile
from service.settings import Settings
from service.storage.encoding import ClipEncoder

FEWEST_CLIPS = 8
"""For which workers are started: to read these takes several times as long as to fork."""

MOST_BYTES = 8 << 20
"""Of the files of a clip that a worker reads; larger ones stream into the store."""

PIPE_BYTES = 1 << 20
"""What a worker may be ahead of the store: bounds the memory of an import. More takes a privilege on Linux."""


@dataclass(frozen=True)
class ReadApart:
    """What a worker made of a clip. encoded: the clip, or why there is none."""

    uploads: list[PackedFile]
    rows: TrackRows
    encoded: EncodedClip | McmlError


@dataclass(frozen=True)
class Task:
    """A clip for a worker. size: bytes of its files."""

    clip: Clip
    options: ImportOptions
    size: int


class ImportWorkers:
    """Each worker reads its clips in their order, and waits while as much as a pipe holds has not been taken."""

    def __init__(self) -> None:
        self._pipes: dict[int, Connection] = {}

    def take(self, number: int) -> ReadApart | None:
        """What a worker made of this clip; ask in the order of clips. None where the importer must read it itself."""
        pipe = self._pipes.get(number)
        if pipe is None or pipe.closed:
            return None
        try:
            answer: ReadApart | None = pipe.recv()
        except (EOFError, OSError):
            # The worker was killed, by want of memory for one: its other clips are the importer's too.
            pipe.close()
            return None
        return answer

    @contextmanager
    def started(self, tasks: dict[int, Task], settings: Settings, processes: int) -> Iterator[None]:
        """Workers for tasks by number, ended at the end of the block."""
        context = multiprocessing.get_context("fork")
        running = []
        shares = _shares(tasks, processes)
        try:
            for share in shares:
                here, there = context.Pipe(duplex=False)
                inherited = [here, *self._pipes.values()]
                worker = context.Process(
                    target=_work, args=([tasks[number] for number in share], settings, there, inherited), daemon=True
                )
                with there:
                    _widen(there)
                    # Without memory for a process there is none, and the importer reads its clips.
                    with suppress(OSError):
                        worker.start()
                        running.append(worker)
                self._pipes |= dict.fromkeys(share, here)
            yield
        finally:
            for pipe in self._pipes.values():
                pipe.close()
            for worker in running:
                worker.terminate()
            for worker in running:
                worker.join()


@contextmanager
def reading_ahead(tasks: dict[int, Task], settings: Settings) -> Iterator[ImportWorkers]:
    """Workers for the tasks, none where that is not worth while."""
    workers = ImportWorkers()
    processes = min(settings.import_processes_at_a_time, len(tasks) // 2)
    if processes < 2 or len(tasks) < FEWEST_CLIPS or not may_fork():
        yield workers
        return
    with workers.started(tasks, settings, processes):
        yield workers


def may_fork() -> bool:
    """Whether nothing of this process would be left in the middle of its work in a copy of it."""
    # Frameworks of macOS start threads that Python does not know. Workers of a pool may have no children.
    is_alone = threading.active_count() == 1 and not multiprocessing.current_process().daemon
    return sys.platform == "linux" and is_alone


def _shares(tasks: dict[int, Task], processes: int) -> list[list[int]]:
    """Numbers of tasks for each worker, each to the one that has the fewest bytes so far."""
    shares: list[list[int]] = [[] for _ in range(processes)]
    loads = [0] * processes
    for number, task in tasks.items():
        least = loads.index(min(loads))
        shares[least].append(number)
        loads[least] += task.size + 1
    return shares


def _widen(pipe: Connection) -> None:
    import fcntl

    # Beyond what one user's pipes may hold together, the usual 64 KiB have to do.
    with suppress(OSError):
        fcntl.fcntl(pipe.fileno(), fcntl.F_SETPIPE_SZ, PIPE_BYTES)


def _work(tasks: Sequence[Task], settings: Settings, answers: Connection, inherited: Sequence[Connection]) -> None:
    """What a worker does, until all is read or nobody is left who takes it."""
    # As long as any process could read from a pipe, writing to it would not tell that the importer was killed.
    for pipe in inherited:
        pipe.close()
    # A handler of the importer's, or the traceback of an interrupt, has no place here.
    for kind in (signal.SIGINT, signal.SIGTERM):
        signal.signal(kind, signal.SIG_DFL)
    # What was inherited is not to be collected, which would copy the memory that holds it.
    gc.freeze()
    with suppress(BrokenPipeError):
        for task in tasks:
            try:
                answer = read_apart(task, settings)
            except Exception:
                # The importer meets the same, and says it in its own words.
                answer = None
            answers.send(answer)


def read_apart(task: Task, settings: Settings) -> ReadApart:
    """Read, check, encode and compress a clip and its files."""
    contents = {part: _content(file) for part, file in task.clip.files.items()}
    clip = Clip(
        task.clip.format,
        {part: SourceFile(file.name, io.BytesIO(contents[part])) for part, file in task.clip.files.items()},
    )
    uploads = [packed(part, content) for part, content in contents.items()]
    rows: TrackRows = []
    encoder = ClipEncoder(_Inline())

    def keep(chunks: Iterator[TrackRows]) -> None:
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
