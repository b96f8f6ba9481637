"""The thread of a server that derives bodies: after imports and edits, a few at a time, and never in their way."""

from __future__ import annotations

import logging
import random
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Literal, TypeAlias

from mcml.errors import McmlError
from mcml_service.clips.bodies import MADE
from mcml_service.clips.derive import keep_bodies
from mcml_service.clips.read_clip import Skeletons
from mcml_service.storage.database import Database
from mcml_service.storage.documents.columns import Listed

Stage: TypeAlias = Literal["columns", "bodies"]

log = logging.getLogger("mcml.derive")

LOOK_SECONDS = 1.0
"""Interval of checks for new documents, also from other processes."""
QUIET_SECONDS = 0.5
"""Waiting time after a commit; other work is checked after each tenth of it."""
PATIENCE_SECONDS = 10.0
"""Behind a server that is always at work, some bodies are derived nevertheless, after so long: meanwhile an import in
another thread gets on several times as slowly."""
LATER_SECONDS = 30.0
"""After the store could not be read or written."""
MANY = 32
"""Number of changed documents after which columns are built in advance."""
TOGETHER, FRAMES = 16, 4096
"""Documents, and frames of several documents, at a time: 40 ms."""


class Deriver:
    """Started and stopped with the server.

    busy: whether the server has something else to do. build: builds the columns of the first queries, of documents
    before their bodies are derived and of bodies after that; its argument is a function that tells whether to continue.
    """

    def __init__(
        self,
        database: Database,
        busy: Callable[[], bool],
        build: Callable[[Stage, Callable[[], bool]], None] = lambda stage, go_on: None,
    ) -> None:
        self._database = database
        self._busy = busy
        self._build = build
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="mcml-derive", daemon=True)
        self._failed: set[tuple[int, int]] = set()
        self._done = self._newest = self._built = -1
        self._moved = 0.0

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        """Stop after the bodies in progress; the next server derives the missing ones."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(timeout=10)

    def derive(self) -> None:
        """Derive all that is missing, if anything was committed since the last time."""
        with self._database.read() as tx:
            newest = tx.newest_commit()
            if newest == self._done:
                return
            # After an edit the next query builds that part again, if there is one.
            builds = self._built < 0 or len(tx.columns.changed_since(self._built)) >= MANY
            keys = tx.bodies.without(MADE)
            missing = tx.columns.documents(keys) if keys else []
        left = [listed for listed in missing if (listed.key, listed.revision) not in self._failed]
        # Of several servers on a store each begins elsewhere.
        first = random.randrange(len(left)) if left else 0
        skeletons: Skeletons = {}
        if builds and self._may_go_on():
            self._build("columns", self._is_running)
        for some in _batches([*left[first:], *left[:first]]):
            if not self._may_go_on():
                return
            keep_bodies(self._database, some, skeletons, self._note)
        if builds and self._may_go_on():
            self._build("bodies", self._is_running)
            self._built = newest
        self._done = newest

    def _run(self) -> None:
        while not self._stopping.is_set():
            pause = LOOK_SECONDS
            try:
                self.derive()
            except McmlError as error:
                log.warning("cannot derive bodies now: %s", error)
                pause = LATER_SECONDS
            except Exception:
                log.exception("cannot derive bodies now")
                pause = LATER_SECONDS
            self._stopping.wait(pause)

    def _note(self, listed: Listed, error: Exception) -> None:
        """Tell once of a document whose body cannot be derived; it is tried again when it has another revision."""
        self._failed.add((listed.key, listed.revision))
        log.warning("cannot derive the body of %r (%s): %s", listed.name, listed.uuid, error)

    def _is_running(self) -> bool:
        return not self._stopping.is_set()

    def _may_go_on(self) -> bool:
        """Wait, for a limited time, until the server is idle and nothing is imported; return whether to continue."""
        until = time.monotonic() + PATIENCE_SECONDS
        while self._others() and time.monotonic() < until:
            if self._stopping.wait(QUIET_SECONDS / 10):
                break
        return not self._stopping.is_set()

    def _others(self) -> bool:
        """Whether others are at work, here or in other processes, which write."""
        if self._busy():
            return True
        with self._database.read() as tx:
            newest = tx.newest_commit()
        if newest != self._newest:
            self._newest, self._moved = newest, time.monotonic()
        return time.monotonic() - self._moved < QUIET_SECONDS


def _batches(documents: Sequence[Listed]) -> Iterator[list[Listed]]:
    some: list[Listed] = []
    frames = 0
    for listed in documents:
        if some and (len(some) == TOGETHER or frames + listed.frames > FRAMES):
            yield some
            some, frames = [], 0
        some.append(listed)
        frames += listed.frames
    if some:
        yield some
