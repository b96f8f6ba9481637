"""Edits of one document of 100,000 frames, against the same edits of one of 1,000: cost grows with what is touched."""

from __future__ import annotations

import io
import sqlite3
import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import httpx

from benchmarks.library import clips, longer, served
from benchmarks.timing import report
from mcml.files.import_options import ImportOptions
from mcml.formats.format import SourceFile
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.settings import Settings
from mcml_service.storage.database import Database

FRAMES = 100_000
REPEAT = 15
ANY = {"if-match": "*"}


def run() -> dict[str, object]:
    what, files = clips()
    name, content = max(files, key=lambda file: _frames(file[1]))
    figures: dict[str, object] = {}
    for size, times in (("short", 1), ("long", -(-FRAMES // _frames(content)))):
        with tempfile.TemporaryDirectory() as folder:
            (clip,) = longer([(name, content)], times)
            print(f"   {size}: the longest of {what}, {_frames(clip[1]):,} frames")
            figures[size] = _edits(Path(folder), clip)
    return figures


def _frames(content: bytes) -> int:
    return int(content.partition(b"Frames:")[2].split()[0])


def _edits(folder: Path, clip: tuple[str, bytes]) -> dict[str, float]:
    path = folder / "store.db"
    database = Database(f"sqlite:///{path}")
    database.migrate()
    done = import_files(database, [SourceFile(clip[0], io.BytesIO(clip[1]))], ImportOptions(), Settings())
    uuid, frames = done.documents[0].uuid, _frames(clip[1])
    database.close()
    with served(f"sqlite:///{path}") as client:
        url = f"/api/v1/documents/{uuid}"
        where = [1 + step * (frames - 1) // (4 * REPEAT) for step in range(4 * REPEAT)]

        def element(number: int) -> None:
            address = f"/mcml/motion/frame[{where[number]}]/frame_bone[2]"
            body = {"attributes": {"Rx": f"{number}.5"}}
            answer = client.patch(f"{url}/elements", json=body, params={"xpath": address}, headers=ANY)
            answer.raise_for_status()

        def compared(_: int) -> None:
            revision = client.get(url).json()["revision"]
            found = client.get(f"{url}/difference", params={"before": revision - 1}).raise_for_status().json()
            assert [bone["frames"] for bone in found["bones"]] == [1]

        def undone(_: int) -> None:
            client.post(f"{url}/undo", headers=ANY).raise_for_status()

        def named(number: int) -> None:
            body = [{"name": f"name-{number}", "first": where[number], "last": where[number]}]
            client.post(f"{url}/labels", json=body, headers=ANY).raise_for_status()

        def cut(number: int) -> None:
            body = {"edits": [{"do": "delete", "first": where[number], "last": where[number]}]}
            client.post(f"{url}/frames", json=body, headers=ANY).raise_for_status()

        return {
            key: value
            for what, action, wanted in (
                ("one value of one frame_bone", element, "<= 20 ms, 100 KB"),
                ("difference to the revision before", compared, ""),
                ("undo of an edit of one value", undone, ""),
                ("a label", named, ""),
                ("a frame cut out", cut, ""),
            )
            for key, value in _measured(path, client, what, action, wanted).items()
        }


def _measured(
    path: Path, client: httpx.Client, what: str, action: Callable[[int], None], wanted: str
) -> dict[str, float]:
    """Medians over HTTP, and of the bytes that reach the write-ahead log, which is emptied before each."""
    times, written = [], []
    for number in range(REPEAT + 2):
        with closing(sqlite3.connect(path)) as connection:
            connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        start = time.perf_counter()
        action(number)
        times.append((time.perf_counter() - start) * 1e3)
        written.append(path.with_name(f"{path.name}-wal").stat().st_size)
    kilobytes = statistics.median(written[2:]) / 1e3
    return {
        f"{what}, ms": report(f"{what}, ms", statistics.median(times[2:]), wanted),
        f"{what}, KB": report(f"{what}, KB to the log", kilobytes),
    }
