"""Readers of other makers in processes of their own: they may hang, crash or take all memory."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from service.errors import FormatError, LimitError
from service.formats import isolated
from service.formats.format import Limits


def program(folder: Path, text: str) -> Path:
    path = folder / "program.py"
    path.write_text(text)
    return path


def test_what_takes_too_long_is_killed(tmp_path: Path) -> None:
    endless = program(tmp_path, "while True: pass")
    with pytest.raises(LimitError, match=r"longer than 0\.5 seconds"):
        isolated.run(endless, [], io.BytesIO(b"x"), Limits(seconds=0.5))


def test_what_takes_too_much_memory_ends(tmp_path: Path) -> None:
    greedy = program(
        tmp_path,
        "import resource\nresource.setrlimit(resource.RLIMIT_AS, (2**28, 2**28))\nx = [bytearray(2**20)]\n"
        "while True: x.append(bytearray(2**20))",
    )
    with pytest.raises(LimitError, match="memory"):
        isolated.run(greedy, [], io.BytesIO(b"x"), Limits())


def test_what_crashes_is_a_damaged_file(tmp_path: Path) -> None:
    crashing = program(tmp_path, "import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)")
    with pytest.raises(FormatError, match="crashed"):
        isolated.run(crashing, [], io.BytesIO(b"x"), Limits())
