"""Processes that read short clips for a server: they stay, for to start one takes longer than to read a hundred clips.

A server has threads and must not fork (`import_workers`). Workers are started afresh when an import first needs them,
and get the bytes of a clip through a pipe. They end with the process that started them, also when that is killed; if
one dies itself, the importer reads what it would have read.
"""

from __future__ import annotations

import io
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice

from service.actions.importing import import_workers
from service.actions.importing.import_workers import AHEAD, FEWEST_CLIPS, ImportWorkers, ReadApart, Task, read_apart
from service.actions.reading.gather_files import Clip
from service.actions.reading.import_options import ImportOptions
from service.formats.format import SourceFile
from service.settings import Settings

WORTH_STARTING = 64
"""Clips for which workers are started; those that are there read fewer, too."""

Sent = tuple[str, dict[str, tuple[str, bytes]], ImportOptions]
"""Format, (name, content) of each part, options."""


@contextmanager
def reading_ahead(
    tasks: dict[int, Task], settings: Settings, pool: ImportPool | None = None
) -> Iterator[ImportWorkers | PooledReading]:
    """Workers for the tasks, none where that is not worth while. pool: of a process that must not fork."""
    processes = min(settings.import_processes_at_a_time, len(tasks) // 2)
    few = processes < 2 or len(tasks) < FEWEST_CLIPS
    if (
        not few
        and not import_workers.may_fork()
        and pool is not None
        and (pool.is_running or len(tasks) >= WORTH_STARTING)
    ):
        reading = PooledReading(pool, tasks, settings)
        try:
            yield reading
        finally:
            reading.close()
        return
    workers = ImportWorkers(tasks)
    if few or not import_workers.may_fork():
        yield workers
        return
    with workers.started(settings, processes):
        yield workers


class ImportPool:
    """The workers of a process. Threads may share it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._executor: ProcessPoolExecutor | None = None

    @property
    def is_running(self) -> bool:
        """Whether there are workers."""
        return self._executor is not None

    def submit(self, sent: Sent, settings: Settings) -> Future[ReadApart | None]:
        """A clip to be read. Starts workers where there are none, or where one has died."""
        for _ in range(2):
            executor = self._started(settings.import_processes_at_a_time)
            try:
                return executor.submit(_read, sent, settings)
            except (BrokenProcessPool, RuntimeError):
                self._forget(executor)
        gone: Future[ReadApart | None] = Future()
        gone.set_result(None)
        return gone

    def close(self) -> None:
        """End the workers."""
        with self._lock:
            executor, self._executor = self._executor, None
        if executor is not None:
            executor.shutdown(wait=True, cancel_futures=True)

    def _started(self, processes: int) -> ProcessPoolExecutor:
        with self._lock:
            if self._executor is None:
                context = multiprocessing.get_context("spawn")
                self._executor = ProcessPoolExecutor(processes, mp_context=context, initializer=_begin)
            return self._executor

    def _forget(self, executor: ProcessPoolExecutor) -> None:
        with self._lock:
            if self._executor is executor:
                self._executor = None
        executor.shutdown(wait=False, cancel_futures=True)


class PooledReading:
    """Clips that the workers of a pool read a little ahead of the importer."""

    def __init__(self, pool: ImportPool, tasks: dict[int, Task], settings: Settings) -> None:
        self._pool = pool
        self._tasks = tasks
        self._settings = settings
        self._numbers = iter(tasks)
        self._made: dict[int, Future[ReadApart | None]] = {}
        self._hand_out(AHEAD * settings.import_processes_at_a_time)

    def take(self, number: int) -> ReadApart | None:
        """What a worker made of this clip. None where the importer must read it itself."""
        made = self._made.pop(number, None)
        if made is None:
            return None
        self._hand_out(1)
        try:
            return made.result()
        except BrokenProcessPool:
            return None

    def is_behind(self, number: int) -> bool:
        """Whether the importer would have to wait for this clip."""
        return number in self._made and not self._made[number].done()

    def close(self) -> None:
        """What is not taken is not wanted any more."""
        for made in self._made.values():
            made.cancel()

    def _hand_out(self, count: int) -> None:
        for number in islice(self._numbers, count):
            task = self._tasks[number]
            parts = {part: (file.name, _content(file)) for part, file in task.clip.files.items()}
            self._made[number] = self._pool.submit((task.clip.format, parts, task.options), self._settings)


def _content(file: SourceFile) -> bytes:
    """The bytes of a file, whose position stays."""
    place = file.stream.tell()
    file.stream.seek(0)
    content = file.stream.read()
    file.stream.seek(place)
    return content


def _begin() -> None:
    """In a worker: to be interrupted is the importer's, and without it there is nothing to do."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: multiprocessing.process.BaseProcess) -> None:
    parent.join()
    os._exit(0)


def _read(sent: Sent, settings: Settings) -> ReadApart | None:
    """In a worker: what `read_apart` makes of a clip; None for an error, which the importer meets in its own words."""
    format_name, parts, options = sent
    files = {part: SourceFile(name, io.BytesIO(content)) for part, (name, content) in parts.items()}
    try:
        return read_apart(Task(Clip(format_name, files), options), settings)
    except Exception:
        return None
