"""Programs in processes of their own: they may hang, crash, take all memory, or lose who watches them."""

from __future__ import annotations

import io
import signal
import subprocess
from pathlib import Path

import psutil
import pytest

from mcml.errors import FormatError, LimitError
from mcml.processes.programs import Watch, end_program, run_reader, start_program

MISBEHAVING = "tests.processes.misbehaving"


def read(*behaviour: str, seconds: float = 60.0, memory: int = 1 << 30) -> bytes:
    with run_reader(MISBEHAVING, *behaviour, stream=io.BytesIO(b"given "), seconds=seconds, memory=memory) as answer:
        return answer.read()


def hanging(behaviour: str = "hang") -> subprocess.Popen[bytes]:
    nothing = subprocess.DEVNULL
    return start_program(MISBEHAVING, behaviour, stdin=nothing, stdout=nothing, stderr=nothing)


def test_what_a_program_writes_is_its_answer() -> None:
    assert read("echo", "name", "5") == b"given name 5"


def test_packages_are_those_of_who_starts_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "of_a_user.py").write_text("def main():\n    print('here')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with run_reader("of_a_user", stream=io.BytesIO(b""), seconds=60, memory=1 << 30) as answer:
        assert answer.read() == b"here\n"


def test_what_takes_too_long_is_killed() -> None:
    with pytest.raises(LimitError, match=r"longer than 0\.5 seconds"):
        read("hang", seconds=0.5)


@pytest.mark.parametrize("behaviour", ["grow", "grow-bounded"])
def test_what_takes_too_much_memory_ends(behaviour: str) -> None:
    with pytest.raises(LimitError, match="more than 256 MiB of memory"):
        read(behaviour, memory=1 << 28)


def test_what_crashes_is_a_damaged_file() -> None:
    with pytest.raises(FormatError, match="crashed"):
        read("crash")


def test_a_program_ends_itself_where_nobody_watches_it() -> None:
    process = hanging("hang-bounded")
    try:
        assert process.wait(timeout=60) == -signal.SIGALRM
    finally:
        end_program(process)


def test_a_watch_takes_speed_from_what_is_long_and_ends_what_is_over() -> None:
    process = hanging()
    nice = []

    def is_over() -> bool:
        nice.append(psutil.Process(process.pid).nice())
        return nice[-1] == 10

    try:
        with Watch(process, is_over, 1 << 30, long_after=0.0) as watch:
            assert process.wait(timeout=60) == -signal.SIGKILL
        assert watch.is_long
        assert not watch.is_too_large
    finally:
        end_program(process)


def test_a_watch_leaves_alone_what_behaves() -> None:
    process = hanging()
    try:
        with Watch(process, lambda: False, 1 << 30) as watch:
            assert process.poll() is None
        assert process.poll() is None
        assert not watch.is_long
    finally:
        end_program(process)
