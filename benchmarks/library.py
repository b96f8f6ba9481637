"""The library that store benchmarks use: the real BVH clips beside the repository, else generated ones."""

from __future__ import annotations

import io
import itertools
import os
import re
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import numpy as np

from mcml.files.import_options import ImportOptions, Label
from mcml.files.shared_skeleton import kept_skeleton
from mcml.formats import FORMATS
from mcml.formats.bvh.hierarchy import shared_hierarchy
from mcml.formats.format import SourceFile
from mcml.formats.text.number_text import detect_style, rows_of_text
from mcml.formats.text.numbers import parse_numbers
from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.actions.importing.import_motion import import_files
from mcml_service.demo import body
from mcml_service.local_secret import read_secret
from mcml_service.settings import Settings, data_folder
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

DOCUMENTS = 100


def clips() -> tuple[str, list[tuple[str, bytes]]]:
    """(what they are, [(name, BVH)]): 100 clips."""
    stated = os.environ.get("MCML_SHARED")
    folder = Path(stated) if stated else Path(__file__).resolve().parents[2] / "shared"
    real = [path for path in sorted((folder / "data" / "bvh").rglob("*.bvh")) if "malformed" not in path.parts]
    if real:
        found = [(path.name, path.read_bytes()) for path in real]
        # A few clips twice, under other names, fill up to a hundred.
        copies = [(f"copy_{name}", content + b"\n") for name, content in found[: max(0, DOCUMENTS - len(found))]]
        return "real BVH files", [*found, *copies][:DOCUMENTS]
    rng = np.random.default_rng(1)
    made = []
    for number in range(DOCUMENTS):
        clip = body.clip(f"walk_{number}", 170, *body.walk(170, float(rng.uniform(5, 20)), 1.0, 6))
        made.append((f"walk_{number}.bvh", b"".join(FORMATS["bvh"].write(clip, "bvh"))))
    return "generated BVH files", made


def longer(files: list[tuple[str, bytes]], times: int) -> list[tuple[str, bytes]]:
    """Clips of usual length from short ones: each followed by variations of itself, every channel shifted a little."""
    rng = np.random.default_rng(3)
    result = []
    for name, content in files:
        parts = re.split(rb"(Frames:\s*\d+\s+Frame Time:\s*\S+[ \t\r]*\n)", content, maxsplit=1, flags=re.IGNORECASE)
        head, middle, body = parts
        values = parse_numbers(body)
        if values is None:
            result.append((name, content))
            continue
        frames = int(middle.split()[1])
        values = values.reshape(frames, -1)
        style = detect_style(body)
        decimals = int(style.partition(":")[2]) if style.startswith("fixed") else 5
        whole = head + middle.replace(str(frames).encode(), str(frames * times).encode(), 1)
        for number in range(times):
            varied = np.round(values + rng.normal(0, 0.5, values.shape[1]), decimals) if number else values
            whole += b"\n".join(rows_of_text(varied, style)) + b"\n"
        result.append((name, whole))
    return result


def labels(rng: np.random.Generator, frames: int) -> tuple[Label, ...]:
    """Motion names on random ranges, from a vocabulary that several clips share."""
    found = []
    for _ in range(6):
        first = int(rng.integers(1, max(2, frames - 10)))
        last = min(frames, first + int(rng.integers(5, 120)))
        found.append(Label(f"move-{rng.integers(0, 250)}", first, last))
    return tuple(found)


def write_plain(tx: Transaction, stored: StoredDocument, path: Path) -> None:
    """The document as MCML without its DOCTYPE: BaseX shall load, not validate."""
    with path.open("wb") as target:
        for number, block in enumerate(export_document(tx, stored, ExportOptions("mcml")).content):
            target.write(re.sub(rb"<!DOCTYPE[^>]*>\n", b"", block) if number < 4 else block)


def forget_skeletons() -> None:
    """As in a new process: what was kept of skeletons that were seen before would make a second load faster."""
    shared_hierarchy.cache_clear()
    kept_skeleton.cache_clear()


def load_together(database: Database, files: list[tuple[str, bytes]]) -> float:
    """Seconds to import the files in one call, as `mcml import folder` and an upload of several files do."""
    forget_skeletons()
    start = time.perf_counter()
    sources = [SourceFile(name, io.BytesIO(content)) for name, content in files]
    done = import_files(database, sources, ImportOptions(), Settings())
    if done.problems:
        raise done.problems[0][1]
    return time.perf_counter() - start


def load(database: Database, files: list[tuple[str, bytes]], *, labelled: bool) -> float:
    """Seconds to import the files, each in a call and a transaction of its own."""
    rng = np.random.default_rng(2)
    settings = Settings()
    options = []
    for _, content in files:
        frames = int(content.partition(b"Frames:")[2].split()[0]) if labelled else 0
        options.append(ImportOptions(labels=labels(rng, frames) if labelled else ()))
    forget_skeletons()
    start = time.perf_counter()
    for (name, content), option in zip(files, options, strict=True):
        done = import_files(database, [SourceFile(name, io.BytesIO(content))], option, settings)
        if done.problems:
            raise done.problems[0][1]
    return time.perf_counter() - start


@contextmanager
def served(url: str) -> Iterator[httpx.Client]:
    """A server process on the store, and a client that keeps its connection."""
    with serving(url) as (_, port):
        # A store in PostgreSQL is open to nobody; whoever runs the server owns this secret.
        headers = {"authorization": f"Bearer {read_secret(data_folder())}"}
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", headers=headers, timeout=60) as client:
            yield client


@contextmanager
def serving(url: str, derive: str = "no") -> Iterator[tuple[int, int]]:
    """A server process on the store: its process id and its port. derive: "yes" or "no", else it would work on bodies
    beside what is measured, and leave them in the store."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environment = os.environ | {"MCML_DATABASE": url, "MCML_PORT": str(port), "MCML_DERIVE": derive}
    command = [sys.executable, "-m", "mcml_service.cli", "serve"]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    try:
        for wait in itertools.count():
            try:
                httpx.get(f"http://127.0.0.1:{port}/healthz")
                break
            except httpx.TransportError:
                if wait > 100:
                    raise
                time.sleep(0.1)
        yield process.pid, port
    finally:
        process.terminate()
        process.wait(10)
