"""Processes that read the short clips of an import, besides the process that stores them.

Reading holds Python's lock, so threads do not help. A command has no threads and forks its workers in some
milliseconds; they end with the import. A server must not fork: its workers are started from a fresh process when an
import first needs them, and stay, for to start one takes longer than to read a hundred clips. In both cases workers get
the bytes of clips through a pipe, and end with the process that started them, also when that is killed. If a worker
dies, the importer reads its clips itself. Unlike the programs of `processes`, workers are not watched, because they run
the same readers as the importer, under the same limits.
"""

from __future__ import annotations

import gc
import multiprocessing
import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures import TimeoutError as StillReadingError
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, nullcontext
from itertools import islice

from mcml.files.clip_files import Clip
from mcml.files.import_options import ImportOptions
from mcml.processes.bounds import end_with_starter
from mcml_service.actions.importing.read_apart import ReadApart, SentClip, read_apart
from mcml_service.settings import Settings

FEWEST_CLIPS = 8
"""For which workers are forked: to read these takes several times as long as to fork."""

WORTH_STARTING = 64
"""Number of clips from which the workers of a server are started; running workers also read fewer."""

MOST_BYTES = 4 << 20
"""Of the files of a clip that a worker reads; larger ones stream into the store."""

AHEAD = 8
"""Clips of each worker that are handed out and not taken yet: bounds the memory of an import."""

TOGETHER = 4
"""Clips that are sent to a worker at a time: each message takes some of the importer's time."""

ROWS_UNSEARCHED = 50_000
"""Objects between two searches for cycles: at Python's own 700 they take a sixth of the importer's time."""

SECONDS_BETWEEN_LOOKS = 1.0
"""After which an importer that waits for a worker looks whether all workers live."""

FRESH = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
"""How a process with threads starts workers."""


class ImportPool:
    """The workers of a process, started with the first clip. Threads may share it. method: how they are started."""

    def __init__(self, method: str = FRESH) -> None:
        self._method = method
        self._lock = threading.Lock()
        self._executor: ProcessPoolExecutor | None = None

    @property
    def is_running(self) -> bool:
        """Whether there are workers."""
        return self._executor is not None

    def submit(self, sent: list[SentClip], settings: Settings) -> Future[list[ReadApart | None]]:
        """Submit clips for reading. Starts workers if there are none, or if one has died."""
        for _ in range(2):
            executor = self._start(settings.import_processes_at_a_time)
            try:
                return executor.submit(_read_all, sent, settings)
            except (BrokenProcessPool, RuntimeError):
                self._forget(executor)
        gone: Future[list[ReadApart | None]] = Future()
        gone.set_result([None] * len(sent))
        return gone

    def wait(self, read: Future[list[ReadApart | None]]) -> list[ReadApart | None] | None:
        """Return the results of submitted clips, None if a worker has died before."""
        while True:
            try:
                return read.result(SECONDS_BETWEEN_LOOKS)
            except (BrokenProcessPool, CancelledError):
                return None
            except StillReadingError:
                self._end_after_a_death()

    def close(self) -> None:
        """End the workers."""
        self._end_after_a_death()
        with self._lock:
            executor, self._executor = self._executor, None
        if executor is not None:
            executor.shutdown(wait=True, cancel_futures=True)

    def _end_after_a_death(self) -> None:
        """End all workers if one has died.

        An executor that reads the result of a worker while that is killed waits for the rest for ever, unless no
        process is left that could write it.
        """
        with self._lock:
            executor = self._executor
            workers = [] if executor is None else list((executor._processes or {}).values())
            if executor is None or all(worker.is_alive() for worker in workers):
                return
            self._executor = None
        results = executor._result_queue
        for worker in workers:
            worker.kill()
        executor.shutdown(wait=False)
        results._writer.close()  # type: ignore[attr-defined]  # of a queue in the standard library

    def _start(self, processes: int) -> ProcessPoolExecutor:
        with self._lock:
            if self._executor is None:
                context = multiprocessing.get_context(self._method)
                self._executor = ProcessPoolExecutor(processes, mp_context=context, initializer=_begin)
            return self._executor

    def _forget(self, executor: ProcessPoolExecutor) -> None:
        with self._lock:
            if self._executor is executor:
                self._executor = None
        executor.shutdown(wait=False, cancel_futures=True)


class ReadingAhead:
    """Clips that workers read a little ahead of the importer, which takes the results in the order of the clips.

    clips: by their numbers; the importer reads other clips itself, and all clips without a pool.
    """

    def __init__(
        self, pool: ImportPool | None, clips: Mapping[int, Clip], options: ImportOptions, settings: Settings
    ) -> None:
        self._pool = pool
        self._clips = clips
        self._options = options
        self._settings = settings
        self._numbers = iter(clips if pool is not None else ())
        self._made: dict[int, tuple[Future[list[ReadApart | None]], int]] = {}
        processes = settings.import_processes_at_a_time
        self._together = max(1, min(TOGETHER, len(clips) // (AHEAD * processes)))
        self._taken = 0
        for _ in range(0, AHEAD * processes, self._together):
            self._hand_out()

    def take(self, number: int) -> ReadApart | None:
        """Return a worker's result for this clip, None if the importer must read it itself."""
        made = self._made.pop(number, None)
        if made is None:
            return None
        self._taken += 1
        if self._taken % self._together == 0:
            self._hand_out()
        read, place = made
        assert self._pool is not None
        results = self._pool.wait(read)
        return None if results is None else results[place]

    def is_behind(self, number: int) -> bool:
        """Whether the importer would have to wait for this clip."""
        return number in self._made and not self._made[number][0].done()

    def close(self) -> None:
        """Drop results that were not taken."""
        for made, _ in self._made.values():
            made.cancel()

    def _hand_out(self) -> None:
        """Send the clips that follow: some together, unless they are large."""
        numbers: list[int] = []
        sent: list[SentClip] = []
        for number in islice(self._numbers, self._together):
            numbers.append(number)
            sent.append(SentClip.of(self._clips[number], self._options))
            if sum(clip.size for clip in sent) >= MOST_BYTES // TOGETHER:
                self._send(numbers, sent)
                numbers, sent = [], []
        if sent:
            self._send(numbers, sent)

    def _send(self, numbers: list[int], sent: list[SentClip]) -> None:
        assert self._pool is not None
        read = self._pool.submit(sent, self._settings)
        self._made.update((number, (read, place)) for place, number in enumerate(numbers))


@contextmanager
def reading_ahead(
    clips: Mapping[int, Clip], options: ImportOptions, settings: Settings, pool: ImportPool | None = None
) -> Iterator[ReadingAhead]:
    """Workers for clips, by number; none where that is not worth while. pool: of a process that must not fork."""
    processes = min(settings.import_processes_at_a_time, len(clips) // 2)
    if processes < 2 or len(clips) < FEWEST_CLIPS:
        chosen = None
    elif may_fork():
        chosen = ImportPool("fork")
    else:
        chosen = pool if pool is not None and (pool.is_running or len(clips) >= WORTH_STARTING) else None
    is_own = chosen is not None and chosen is not pool
    with _rarely_searched() if is_own else nullcontext():
        reading = ReadingAhead(chosen, clips, options, settings)
        try:
            yield reading
        finally:
            reading.close()
            if chosen is not None and is_own:
                chosen.close()


def may_fork() -> bool:
    """Whether nothing of this process would be left in the middle of its work in a copy of it."""
    # Frameworks of macOS start threads that Python does not know. Workers of a pool may have no children.
    is_alone = threading.active_count() == 1 and not multiprocessing.current_process().daemon
    return sys.platform == "linux" and is_alone


@contextmanager
def _rarely_searched() -> Iterator[None]:
    """Exclude existing objects from garbage collection while many rows are made and freed, and collect rarely."""
    searched = gc.get_threshold()
    gc.freeze()
    gc.set_threshold(ROWS_UNSEARCHED, *searched[1:])
    try:
        yield
    finally:
        gc.set_threshold(*searched)
        gc.unfreeze()


def _begin() -> None:
    """Start a worker: it ignores interrupts, which the importer handles, and ends with the importer."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with_starter()


def _read_all(sent: list[SentClip], settings: Settings) -> list[ReadApart | None]:
    """Read clips in a worker."""
    return [read_apart(file, settings) for file in sent]
