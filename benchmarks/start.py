"""Processor time from the start of a process to its first answer."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import httpx

from benchmarks.library import serving
from benchmarks.timing import report

ROUNDS = 5
COMMANDS = {
    "mcml --version": ("--version",),
    "mcml ls, 20 documents": ("ls", "--limit", "20"),
    "mcml ls, 20 documents, words and order": ("ls", "walk", "--sort", "-duration", "--limit", "20"),
    "mcml facets": ("facets",),
}
FIRST = {
    "a page": ("/documents", {"limit": "60", "sort": "newest", "with": "thumbnail,labels,passport"}),
    "facets": ("/facets", {}),
    "an XPath": ("/xpath", {"q": "count(//frame)"}),
}


def measure_start(store: Path) -> dict[str, float]:
    """Of commands, and of servers with one question each; the least of several, in seconds."""
    figures = {}
    url = f"sqlite:///{store}"
    for name, words in COMMANDS.items():
        figures[name] = report(f"{name}, s of processor time", min(_command(url, words) for _ in range(ROUNDS)))
    for name, (path, given) in FIRST.items():
        least = min(_served(url, path, given) for _ in range(ROUNDS))
        figures[name] = report(f"mcml serve until {name} is answered, s of processor time", least, "<= 2")
    return figures


def _command(url: str, words: tuple[str, ...]) -> float:
    # Else each process compiles modules that others have compiled.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "mcml_service.cli", *words]
    subprocess.run(command, env=environment | {"MCML_DATABASE": url}, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _served(url: str, path: str, given: dict[str, str]) -> float:
    with serving(url) as (process, port):
        httpx.get(f"http://127.0.0.1:{port}/api/v1{path}", params=given, timeout=60).raise_for_status()
        spent = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(spent[11]) + int(spent[12])) / os.sysconf("SC_CLK_TCK")
