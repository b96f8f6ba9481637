"""What workers do in tests in place of a job. Their processes import this module, so it imports little."""

from __future__ import annotations

import gc
import os
import signal
import struct
import sys
import threading
import time
from multiprocessing.queues import SimpleQueue
from pathlib import Path
from typing import Any

from mcml_service.analysis.interface import Part
from mcml_service.jobs.remote_motions import StoredMotions, database_of
from mcml_service.jobs.telling import Teller
from mcml_service.jobs.worker import Task
from mcml_service.jobs.workers import Crew

Parts = dict[str, Part]


def endless(task: Task, _crew: Crew) -> None:
    """Tell for ever, and end when that is wanted."""
    with Teller(database_of(*task.urls), task.uuid, task.runner) as tell:
        while True:
            tell("for ever", 0.5)
            time.sleep(0.05)


def deaf(task: Task, _crew: Crew) -> None:
    """Tell once, and never listen."""
    with Teller(database_of(*task.urls), task.uuid, task.runner) as tell:
        tell("deaf", 0.5)
        while True:
            time.sleep(0.05)


def dying(times: int, place: str, task: Task, _crew: Crew) -> Parts:
    """Succeed after the worker was killed so often."""
    with Teller(database_of(*task.urls), task.uuid, task.runner):
        with open(place, "a") as marks:
            marks.write("x")
        if os.path.getsize(place) <= times:
            os.kill(os.getpid(), signal.SIGKILL)
    return {"numbers": Part("table", {"value": 1})}


def greedy(mebibytes: int, _task: Task, _crew: Crew) -> Parts:
    """Take so much memory, in small pieces."""
    held = [bytes(1 << 20) for _ in range(mebibytes)]
    return {"numbers": Part("table", {"value": len(held)})}


def meeting(place: str, task: Task, _crew: Crew) -> Parts:
    """Wait until another process does this too."""
    _wait_for_another(place)
    return {"numbers": Part("table", {"value": _processes(place)})}


def surroundings(_task: Task, _crew: Crew) -> Parts:
    """Say what this process has imported, and how many of its threads are not Python's."""
    native = len(os.listdir("/proc/self/task")) - threading.active_count()
    return {"numbers": Part("table", {"modules": sorted(sys.modules), "native_threads": native})}


def spread(function: Any, place: str, task: Task, crew: Crew) -> list[Any]:
    """Give twelve pieces to a crew. The place is what they share."""
    return StoredMotions(task.urls, crew, [], None).spread(function, range(12), (place,))


def spread_as_job(function: Any, place: str, task: Task, crew: Crew) -> Parts:
    with Teller(database_of(*task.urls), task.uuid, task.runner):
        return {"numbers": Part("table", {"value": spread(function, place, task, crew)})}


def with_another(_piece: int, place: str) -> bool:
    """Return whether another process had a piece too."""
    return _wait_for_another(place)


def dying_piece(piece: int, place: str) -> int:
    """Kill the first process that has the fourth piece."""
    if piece == 3 and not os.path.exists(f"{place}/killed"):
        Path(place, "killed").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return 10 * piece


def deadly_piece(piece: int, place: str) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def endless_piece(_piece: int, place: str) -> None:
    """Leave the number of this process, and never end."""
    Path(place, str(os.getpid())).touch()
    while True:
        time.sleep(0.05)


def process(_piece: int, place: str) -> int:
    return os.getpid()


def places(_task: Task, crew: Crew) -> int:
    return crew.places()


def places_of_two(place: str, task: Task, crew: Crew) -> int:
    """Count while two jobs run."""
    _wait_for_another(place)
    counted = crew.places()
    Path(place, f"counted by {os.getpid()}").touch()
    while sum(name.startswith("counted") for name in os.listdir(place)) < 2:
        time.sleep(0.01)
    return counted


def half_a_result(place: str) -> None:
    """Send the beginning of a result and then nothing."""
    (pipe,) = {queue._writer.fileno() for queue in gc.get_objects() if isinstance(queue, SimpleQueue)}
    os.write(pipe, struct.pack("!i", 1000) + b"half")
    Path(place).write_text(str(os.getpid()))
    threading.Event().wait()


def _wait_for_another(place: str) -> bool:
    Path(place, str(os.getpid())).touch()
    end = time.monotonic() + 60
    while _processes(place) < 2 and time.monotonic() < end:
        time.sleep(0.01)
    return _processes(place) > 1


def _processes(place: str) -> int:
    return sum(name.isdigit() for name in os.listdir(place))
