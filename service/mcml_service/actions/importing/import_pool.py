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

from mcml.errors import Notice
from mcml.files.gather_files import Clip
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.importing import import_workers
from mcml_service.actions.importing.import_workers import (
    AHEAD,
    FEWEST_CLIPS,
    MOST_BYTES,
    ImportWorkers,
    ReadApart,
    Task,
    read_apart,
)
from mcml_service.settings import Settings

WORTH_STARTING = 64
"""Clips for which workers are started; those that are there read fewer, too."""

TOGETHER = 4
"""Clips that a worker is sent at a time: to send one and to hear of it takes the importer's time, however short."""

Sent = tuple[str, dict[str, tuple[str, bytes, tuple[Notice, ...]]], ImportOptions]
"""Format, (name, content, notices) of each part, options."""


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

    def submit(self, sent: list[Sent], settings: Settings) -> Future[list[ReadApart | None]]:
        """Clips to be read. Starts workers where there are none, or where one has died."""
        for _ in range(2):
            executor = self._started(settings.import_processes_at_a_time)
            try:
                return executor.submit(_read_all, sent, settings)
            except (BrokenProcessPool, RuntimeError):
                self._forget(executor)
        gone: Future[list[ReadApart | None]] = Future()
        gone.set_result([None] * len(sent))
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
        self._made: dict[int, tuple[Future[list[ReadApart | None]], int]] = {}
        processes = settings.import_processes_at_a_time
        self._together = max(1, min(TOGETHER, len(tasks) // (AHEAD * processes)))
        self._taken = 0
        for _ in range(0, AHEAD * processes, self._together):
            self._hand_out()

    def take(self, number: int) -> ReadApart | None:
        """What a worker made of this clip. None where the importer must read it itself."""
        made = self._made.pop(number, None)
        if made is None:
            return None
        self._taken += 1
        if self._taken % self._together == 0:
            self._hand_out()
        read, place = made
        try:
            return read.result()[place]
        except BrokenProcessPool:
            return None

    def is_behind(self, number: int) -> bool:
        """Whether the importer would have to wait for this clip."""
        return number in self._made and not self._made[number][0].done()

    def close(self) -> None:
        """What is not taken is not wanted any more."""
        for made, _ in self._made.values():
            made.cancel()

    def _hand_out(self) -> None:
        """Send the clips that follow: some together, unless they are large."""
        numbers: list[int] = []
        sent: list[Sent] = []
        size = 0
        for number in islice(self._numbers, self._together):
            task = self._tasks[number]
            parts = {part: (file.name, _content(file), file.notices) for part, file in task.clip.files.items()}
            numbers.append(number)
            sent.append((task.clip.format, parts, task.options))
            size += sum(len(content) for _, content, _ in parts.values())
            if size >= MOST_BYTES // TOGETHER:
                self._send(numbers, sent)
                numbers, sent, size = [], [], 0
        if sent:
            self._send(numbers, sent)

    def _send(self, numbers: list[int], sent: list[Sent]) -> None:
        read = self._pool.submit(sent, self._settings)
        self._made.update((number, (read, place)) for place, number in enumerate(numbers))


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


def _read_all(sent: list[Sent], settings: Settings) -> list[ReadApart | None]:
    """In a worker: what it makes of clips."""
    return [_read(one, settings) for one in sent]


def _read(sent: Sent, settings: Settings) -> ReadApart | None:
    """In a worker: what `read_apart` makes of a clip; None for an error, which the importer meets in its own words."""
    format_name, parts, options = sent
    files = {part: SourceFile(name, io.BytesIO(content), notices) for part, (name, content, notices) in parts.items()}
    try:
        return read_apart(Task(Clip(format_name, files), options), settings)
    except Exception:
        return None
