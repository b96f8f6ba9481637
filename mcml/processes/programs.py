"""Start, watch and end programs that work on untrusted files.

Decoders of sound, FBX and USD may crash, hang or take all memory. In a process of their own that ends in an error of
one request. A program is a module with `main`, which bounds itself too (`bounds.py`), so that it ends when the process
that watches it has ended.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import IO, BinaryIO

import psutil

from mcml.errors import FormatError, LimitError

LOOK_SECONDS = 0.02
_LAST_WORDS = 1 << 16
"""Limit of a program's last output; its last line has the kind of error."""


def start_program(
    module: str, *arguments: str, stdin: int | IO[bytes], stdout: int | IO[bytes], stderr: int | IO[bytes]
) -> subprocess.Popen[bytes]:
    """A process that runs `main` of a module, of this very installation."""
    text = f"import sys; sys.path[:0] = {_homes()!r}; from {module} import main; main()"
    # Packages may be those of a user, or of PYTHONPATH: where they are for this process, they are for that one.
    command = [sys.executable, "-P", "-c", text, *arguments]
    return subprocess.Popen(command, stdin=stdin, stdout=stdout, stderr=stderr)


def _homes() -> list[str]:
    """The folders of the packages of this installation: one folder in a wheel's, up to three in a checkout."""
    packages = (sys.modules.get(name) for name in ("mcml", "mcml_schemas", "mcml_service"))
    files = [package.__file__ for package in packages if package is not None]
    return list(dict.fromkeys(str(Path(file).resolve().parents[1]) for file in files if file is not None))


def end_program(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and close its pipes."""
    process.kill()
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            with suppress(BrokenPipeError):
                stream.close()
    process.wait()


class Watch(threading.Thread):
    """Watches a process inside a `with` block: kills it if `is_over` is true, or if it uses too much memory.

    Memory is measured from outside, because memory reserved by libraries may escape the limits of the system. memory:
    bytes. long_after: seconds after which a process gets a lower priority. is_long, is_too_large: observed state.
    """

    def __init__(
        self,
        process: subprocess.Popen[bytes],
        is_over: Callable[[], bool],
        memory: int,
        long_after: float | None = None,
    ) -> None:
        super().__init__(daemon=True)
        self.is_long = False
        self.is_too_large = False
        self._process = process
        self._is_over = is_over
        self._memory = memory
        self._long_after = long_after
        self._ended = threading.Event()

    def __enter__(self) -> Watch:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._ended.set()
        self.join()

    def run(self) -> None:
        began = time.monotonic()
        with suppress(psutil.NoSuchProcess):
            seen = psutil.Process(self._process.pid)
            while not self._ended.wait(LOOK_SECONDS):
                self.is_too_large = seen.memory_info().rss > self._memory
                if self.is_too_large or self._is_over():
                    self._process.kill()
                    return
                if self._long_after is not None and not self.is_long and time.monotonic() - began > self._long_after:
                    self.is_long = True
                    seen.nice(10)


def run_reader(module: str, *arguments: str, stream: BinaryIO, seconds: float, memory: int) -> BinaryIO:
    """Run a program with a file as its input; return its output as a temporary file.

    Raises LimitError if it takes too long or too much memory (bytes), FormatError if it fails.
    """
    target = tempfile.TemporaryFile()  # noqa: SIM115  # the caller closes it
    try:
        with tempfile.TemporaryFile() as source, tempfile.TemporaryFile() as error_file:
            stream.seek(0)
            shutil.copyfileobj(stream, source, 1 << 20)
            source.seek(0)
            _run(
                start_program(module, *arguments, stdin=source, stdout=target, stderr=error_file),
                error_file,
                seconds,
                memory,
            )
    except BaseException:
        target.close()
        raise
    target.seek(0)
    return target


def _run(process: subprocess.Popen[bytes], said: BinaryIO, seconds: float, memory: int) -> None:
    end = time.monotonic() + seconds
    try:
        with Watch(process, lambda: time.monotonic() > end, memory) as watch:
            status = process.wait()
    finally:
        end_program(process)
    if not status:
        return
    said.seek(max(0, said.seek(0, 2) - _LAST_WORDS))
    if watch.is_too_large or b"MemoryError" in said.read():
        raise LimitError(f"reading the file took more than {memory >> 20} MiB of memory", remedy="Cut it into parts.")
    if time.monotonic() > end:
        raise LimitError(f"reading the file took longer than {seconds:g} seconds", remedy="Cut it into parts.")
    raise FormatError("the file is damaged: its reader crashed", remedy="Save it again with another program.")
