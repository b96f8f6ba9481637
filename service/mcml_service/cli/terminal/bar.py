"""A bar for work on many things, with its pace."""

from __future__ import annotations

import time

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from mcml.client.pace import Pace
from mcml_service.cli.terminal.opening import console

SECONDS_DRAWN = 0.1
"""Between two drawings of the bar, each of which takes as long as to read a short clip."""


class Bar:
    """A progress bar with count, speed and remaining time.

    doing: a word for the work. things: their name. The caller draws it: with a drawing thread, imports could not fork.
    """

    def __init__(self, doing: str, things: str = "files", *, disable: bool) -> None:
        what = TextColumn("{task.description}", markup=False)
        columns = (what, BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[pace]}"))
        self._bar = Progress(*columns, console=console, transient=True, disable=disable, auto_refresh=False)
        self._task = self._bar.add_task(doing, total=None, pace="")
        self._pace = Pace(things)
        self._drawn = 0.0

    def __enter__(self) -> Bar:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def tell(self, done: int, of: int, name: str) -> None:
        """Draw it, if it was not just now."""
        if time.monotonic() - self._drawn > SECONDS_DRAWN:
            self._pace.tell(done, of)
            pace = str(self._pace)
            self._bar.update(self._task, description=name[:40], completed=done, total=of, pace=pace, refresh=True)
            self._drawn = time.monotonic()
