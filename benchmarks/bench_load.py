"""A hundred people read frames and ask XPath, ten write, for ten minutes: SQLite, PostgreSQL, and two servers on that.

Each person has a token, waits a while (THINK, exponential), asks, and asks again where told to (503 or 429 with
Retry-After). Latencies are of one answer, without waits between attempts; they hold the time that a client of this
program waits for its turn. `MCML_LOAD_SECONDS` makes it shorter, `MCML_LOAD_STORES` names some of the stores.
"""

from __future__ import annotations

import asyncio
import os
import random
import statistics
import tempfile
import time
from collections import Counter
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack, ExitStack, asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import httpx
import numpy as np

from benchmarks.library import clips, load_together, serving
from benchmarks.timing import report
from mcml_service.storage.database import Database
from tests import postgres

SECONDS = float(os.environ.get("MCML_LOAD_SECONDS", "600"))
STORES = {"sqlite": 1, "postgresql": 1, "postgresql by two": 2}
READERS, WRITERS = 100, 10
THINK = 1.5
"""Seconds, in the mean, between two requests of a person."""

CLIPS, OWN = 60, 3
"""Clips of the library; and how many each writer edits, imports beside them and deletes again."""

ATTEMPTS = 20
EVERY = 2.0
"""Seconds between two looks at what the servers use."""


@dataclass
class Seen:
    """answers: (seconds since the start, what was asked, ms). sizes: (seconds since the start, MB of all servers)."""

    start: float = field(default_factory=time.perf_counter)
    answers: list[tuple[float, str, float]] = field(default_factory=list)
    statuses: Counter[int] = field(default_factory=Counter)
    sizes: list[tuple[float, float]] = field(default_factory=list)
    refused: int = 0
    lost: list[str] = field(default_factory=list)

    @property
    def now(self) -> float:
        return time.perf_counter() - self.start


_files = cache(clips)


def run() -> dict[str, Any]:
    wanted = os.environ.get("MCML_LOAD_STORES", ",".join(STORES)).split(",")
    found: dict[str, Any] = {}
    for name in wanted:
        print(f"   -- {name}", flush=True)
        with _library(name.partition(" ")[0]) as url, ExitStack() as stack:
            database = Database(url)
            with database.write() as tx:
                tokens = [tx.tokens.add(f"person {number}", None) for number in range(READERS + WRITERS)]
            servers = [stack.enter_context(serving(url)) for _ in range(STORES[name])]
            database.close()
            found[name] = asyncio.run(_measured(servers, tokens))
    if {"postgresql", "postgresql by two"} <= set(found):
        one, two = (found[name]["processor"] for name in ("postgresql", "postgresql by two"))
        found["two"] = report("processor time of a request, two servers / one", two / one, "<= 1.1")
    return found


@contextmanager
def _library(kind: str) -> Iterator[str]:
    with ExitStack() as stack:
        if kind == "sqlite":
            url = f"sqlite:///{stack.enter_context(tempfile.TemporaryDirectory())}/store.db"
        else:
            url = stack.enter_context(postgres.new_database(stack.enter_context(postgres.server())))
        database = Database(url)
        database.migrate()
        what, files = _files()
        load_together(database, [(f"{n}-{name}", content) for n, (name, content) in enumerate(files[:CLIPS])])
        database.close()
        print(f"      {what}, {min(CLIPS, len(files))} of them")
        yield url


async def _measured(servers: list[tuple[int, int]], tokens: list[str]) -> dict[str, Any]:
    async with _people(servers, tokens) as people:
        page = await people[0].get("/documents", params={"limit": CLIPS})
        frames = {item["id"]: item["frames"] for item in page.json()["items"]}
        idle = Seen()
        rng = random.Random(0)
        for _ in range(100):
            await _read(people[0], idle, rng, frames)
        seen, used = Seen(), _processor(servers)
        end = seen.start + SECONDS
        work = [_person(one, seen, number, frames, end) for number, one in enumerate(people)]
        await asyncio.gather(_watch(servers, seen, end), *work)
        return _figures(idle, seen, _processor(servers) - used)


@asynccontextmanager
async def _people(servers: list[tuple[int, int]], tokens: list[str]) -> AsyncIterator[list[httpx.AsyncClient]]:
    """Clients with a token each; those of two servers ask one and the other."""
    async with AsyncExitStack() as stack:
        found = []
        for number, token in enumerate(tokens):
            base = f"http://127.0.0.1:{servers[number % len(servers)][1]}/api/v1"
            client = httpx.AsyncClient(base_url=base, headers={"authorization": f"Bearer {token}"}, timeout=120)
            found.append(await stack.enter_async_context(client))
        yield found


async def _person(client: httpx.AsyncClient, seen: Seen, number: int, frames: dict[str, int], end: float) -> None:
    rng = random.Random(number)
    own: list[str] = []
    while (left := end - time.perf_counter()) > 0:
        await asyncio.sleep(min(left, rng.expovariate(1 / THINK)))
        if number < READERS:
            await _read(client, seen, rng, frames)
        else:
            await _write(client, seen, rng, own)


async def _read(client: httpx.AsyncClient, seen: Seen, rng: random.Random, frames: dict[str, int]) -> None:
    kind = rng.choices(["frames", "xpath", "list"], [6, 3, 1])[0]
    params: dict[str, Any]
    if kind == "frames":
        uuid, many = rng.choice(list(frames.items()))
        first = rng.randrange(1, max(2, many - 64))
        path, params = f"/documents/{uuid}/frames", {"first": first, "last": min(many, first + 63)}
    elif kind == "xpath":
        k = round(rng.uniform(10, 90), 3)
        name = rng.choice(["Root", "left_up_leg", "right_low_leg"])
        path, params = "/xpath", {"q": f"//frame[frame_bone[@name='{name}']/@Rx > {k}]", "limit": 100}
    else:
        path, params = "/documents", {"sort": "newest", "limit": 60, "offset": rng.randrange(0, 20)}
    await _asked(client, seen, kind, "GET", path, params=params)


async def _write(client: httpx.AsyncClient, seen: Seen, rng: random.Random, own: list[str]) -> None:
    """Imports a clip, edits one of those, or deletes one."""
    kind = rng.choice(["import", "edit", "edit", "edit", "delete"])
    if kind == "import" or not own:
        files = {"file": (f"take {rng.random()}.bvh", _take(rng))}
        answer = await _asked(client, seen, "import", "POST", "/documents", files=files)
        if answer is not None and answer.status_code == 201:
            own.append(answer.json()["documents"][0]["id"])
    elif kind == "delete" and len(own) > OWN:
        uuid = own.pop(rng.randrange(len(own)))
        await _asked(client, seen, "delete", "DELETE", f"/documents/{uuid}", headers={"if-match": "*"})
    else:
        edit = {"do": "reverse", "first": 1, "last": rng.randrange(2, 100)}
        path = f"/documents/{rng.choice(own)}/frames"
        await _asked(client, seen, "edit", "POST", path, json={"edits": [edit]}, headers={"if-match": "*"})


def _take(rng: random.Random) -> bytes:
    """Two seconds of numbers for the skeleton of a clip of the library."""
    _, files = _files()
    head, motion, _ = files[rng.randrange(len(files))][1].partition(b"MOTION")
    frames, channels = 120, sum(int(part.split()[0]) for part in head.split(b"CHANNELS")[1:])
    lines = "\n".join(" ".join(f"{rng.uniform(-90, 90):.4f}" for _ in range(channels)) for _ in range(frames))
    return head + motion + f"\nFrames: {frames}\nFrame Time: 0.0083333\n{lines}\n".encode()


async def _asked(
    client: httpx.AsyncClient, seen: Seen, kind: str, method: str, path: str, **given: Any
) -> httpx.Response | None:
    """An answer that is no refusal; asks again as it is told to."""
    for attempt in range(ATTEMPTS):
        start = time.perf_counter()
        try:
            answer = await client.request(method, path, **given)
        except httpx.TransportError as error:
            seen.lost.append(f"{method} {path}: {error!r}")
            return None
        seen.answers.append((seen.now, kind, 1000 * (time.perf_counter() - start)))
        seen.statuses[answer.status_code] += 1
        if answer.status_code not in (429, 503):
            if answer.status_code >= 400:
                seen.lost.append(f"{method} {path} {answer.status_code}: {answer.text[:300]}")
            return answer
        seen.refused += attempt == 0
        await asyncio.sleep(float(answer.headers["retry-after"]))
    seen.lost.append(f"{method} {path}: refused {ATTEMPTS} times")
    return None


async def _watch(servers: list[tuple[int, int]], seen: Seen, end: float) -> None:
    while time.perf_counter() < end:
        seen.sizes.append((seen.now, sum(_resident(pid) for process, _ in servers for pid in _family(process))))
        await asyncio.sleep(EVERY)


def _family(pid: int) -> list[int]:
    """A process and what it started."""
    found = [pid]
    for one in found:
        for task in Path(f"/proc/{one}/task").glob("*/children"):
            found += [int(child) for child in task.read_text().split()]
    return found


def _resident(pid: int) -> float:
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    except FileNotFoundError:
        return 0.0


def _processor(servers: list[tuple[int, int]]) -> float:
    """Seconds of the servers' processes, and of those of them that have ended."""
    fields = [Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split() for pid, _ in servers]
    return sum(sum(map(int, one[11:15])) for one in fields) / os.sysconf("SC_CLK_TCK")


def _figures(idle: Seen, seen: Seen, processor: float) -> dict[str, Any]:
    """All answers of the three thirds."""
    found: dict[str, Any] = {"answers": len(seen.answers), "statuses": dict(seen.statuses), "lost": seen.lost[:20]}
    print(f"      {len(seen.answers):,} answers in {SECONDS:g} s: {dict(sorted(seen.statuses.items()))}")
    for line in seen.lost[:5]:
        print(f"      {line}")
    found["refused"] = report("refused at first, %", 100 * seen.refused / len(seen.answers), "< 1")
    found["failed"] = report("failed, or refused for good", len(seen.lost), "0")
    for kind in sorted({kind for _, kind, _ in seen.answers}):
        times = [ms for _, one, ms in seen.answers if one == kind]
        alone = [ms for _, one, ms in idle.answers if one == kind]
        middle = statistics.median(times)
        found[kind] = report(f"{kind}: median, ms", middle)
        if alone:
            report("   of an idle server", statistics.median(alone))
        found[f"{kind} p99"] = report("   99th percentile", float(np.percentile(times, 99)))
    thirds = [range(int(SECONDS * n / 3), int(SECONDS * (n + 1) / 3)) for n in range(3)]
    slow = [float(np.percentile([ms for at, _, ms in seen.answers if int(at) in third], 99)) for third in thirds]
    sizes = [max(size for at, size in seen.sizes if int(at) in third) for third in thirds]
    for number in range(3):
        report(f"99th percentile of third {number + 1}, ms", slow[number])
        report("   most memory, MB", sizes[number])
    found["growth"] = report("most memory, last third / first", sizes[2] / sizes[0], "<= 1.05")
    found["processor"] = report("processor time of a request, ms", 1000 * processor / len(seen.answers))
    return {**found, "p99": slow, "memory": sizes}
