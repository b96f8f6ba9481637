"""A fixed set of questions on three sizes of library: our server, BaseX, lxml, PostgreSQL's xpath(), in one run."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from benchmarks import basex, basex_client
from benchmarks.library import serving
from benchmarks.xpath_engines import (
    Answer,
    BaseX,
    Lxml,
    Ours,
    differ,
    joined,
    median_ms,
    postgres,
    same_of_one,
)
from benchmarks.xpath_library import SIZES, Library, Size, build
from benchmarks.xpath_questions import QUESTIONS, Question, constants
from benchmarks.xpath_table import Row, print_table

WARMING = range(3)
TIMED = range(3, 18)
ENOUGH = 7
"""Repetitions after which a question is left that took SECONDS together."""
SECONDS = 0.5
SLOW = TIMED[:3]
"""lxml and PostgreSQL are asked less often: what they take is far from noise."""
HEAVY = range(18, 20)
"""For the memory of the server."""
WARMING_AGAIN = range(20, 22)
TIMED_AGAIN = range(22, 37)
"""After the edit."""
COLD = range(37, 45)
"""For the virtual machine of BaseX, and as much for us: all questions in turn, before anything is timed."""


@dataclass
class Run:
    """What is measured. differences: where two engines did not agree."""

    library: Library
    rows: dict[str, Row] = field(default_factory=lambda: {question.name: Row(question) for question in QUESTIONS})
    differences: list[str] = field(default_factory=list)
    idle: dict[int, float] = field(default_factory=dict)

    def constants(self, number: int) -> dict[str, str]:
        return constants(number, self.library.pairs)

    def document(self, question: Question, number: int, size: Size) -> int | None:
        """Number of the document that is asked; None: all."""
        if question.scope == "each":
            return list(size.documents)[number % len(size.documents)]
        return self.library.one if question.scope == "one" else None

    def compare(self, question: Question, who: str, answer: Answer, other: Answer) -> None:
        if differ(answer, other):
            shown = [str(item if isinstance(item, float) else f"{len(item)} items") for item in (answer, other)]
            self.differences.append(f"{question.name}: {who}: {shown[0]}, we: {shown[1]}")


def run() -> dict[str, object]:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        measured = Run(build(folder))
        print(f"   library: {measured.library.what}; {', '.join(map(str, SIZES))} documents", flush=True)
        ours: dict[tuple[str, int], Answer] = {}
        asked = "not at all"
        with ExitStack() as stack:
            client = None
            if basex.available():
                (folder / "basex").mkdir()
                client = stack.enter_context(basex_client.serving(folder / "basex"))
                asked = client.asked
                print(f"   BaseX is asked {asked}", flush=True)
            else:
                print("   BaseX is not installed (Debian package basex): it is left out")
            for number, size in measured.library.sizes.items():
                peer = None
                if client is not None:
                    peer = BaseX(client, f"u{number}", size)
                _ask_servers(measured, number, size, peer, ours)
        print("   lxml, one document after the other", flush=True)
        _ask_lxml(measured, ours)
        print(f"   PostgreSQL, {SIZES[0]} documents", flush=True)
        _ask_postgres(measured, ours)
    figures = print_table(list(measured.rows.values()), measured.idle)
    if measured.differences:
        raise RuntimeError("The engines disagree: " + "; ".join(measured.differences))
    return {"library": measured.library.what, "basex": asked, **figures}


def _ask_servers(
    measured: Run, number: int, size: Size, peer: BaseX | None, answers: dict[tuple[str, int], Answer]
) -> None:
    """Us and BaseX, question by question in turn; then after an edit; then the memory of our server."""
    with serving(size.url) as (process, port):
        ours = Ours(process, port, size)
        ours.empty(0)
        print(f"   {number} documents", flush=True)
        for k in COLD if number == min(SIZES) else ():
            for question in QUESTIONS:
                asked, document = measured.constants(k), measured.document(question, k, size)
                ours.ask(question, asked, document)
                if peer is not None:
                    peer.ask(question, asked, document)
        for question in QUESTIONS:
            row = measured.rows[question.name]
            _timed(measured, row, question, number, size, ours, peer)
            asked, document = measured.constants(TIMED[0]), measured.document(question, TIMED[0], size)
            mine = ours.same(question, ours.ask(question, asked, document))
            answers[question.name, number] = mine
            if peer is not None:
                theirs = peer.same(question, peer.ask(question, asked, document))
                measured.compare(question, f"BaseX, {number} documents", theirs, mine)
        ours.edit(measured.library.one, "1.5")
        if peer is not None:
            peer.edit(measured.library.one, "1.5")
        for question in (question for question in QUESTIONS if question.kind == "label"):
            _timed(measured, measured.rows[question.name], question, number, size, ours, peer, edited=True)
    with serving(size.url) as (process, port):
        _memory(measured, number, size, Ours(process, port, size))


def _timed(
    measured: Run,
    row: Row,
    question: Question,
    number: int,
    size: Size,
    ours: Ours,
    peer: BaseX | None,
    *,
    edited: bool = False,
) -> None:
    warming, timed = (WARMING_AGAIN, TIMED_AGAIN) if edited else (WARMING, TIMED)
    ours_at, basex_at = (row.ours_edited, row.basex_edited) if edited else (row.ours, row.basex)
    cases = [(k, measured.constants(k), measured.document(question, k, size)) for k in (*warming, *timed)]

    def net(empty: Callable[[int], object], ask: Callable[[dict[str, str], int | None], object]) -> float:
        """Median milliseconds above an empty request, asked in turn."""
        nothing: list[float] = []
        whole: list[float] = []
        for k, asked, document in cases[: len(warming) + question.times]:
            if len(whole) >= len(warming) + ENOUGH and sum(whole) > SECONDS:
                break
            nothing.append(_seconds(partial(empty, k)))
            whole.append(_seconds(partial(ask, asked, document)))
        return median_ms(whole[len(warming) :]) - median_ms(nothing[len(warming) :])

    ours_at[number] = net(ours.empty, partial(ours.ask, question))
    if peer is not None:
        basex_at[number] = net(peer.empty, partial(peer.ask, question))


def _seconds(action: Callable[[], object]) -> float:
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def _memory(measured: Run, number: int, size: Size, ours: Ours) -> None:
    """The most that a question takes over the server at rest, which is: started, and asked a constant."""
    ours.empty(0)
    idle = ours.resident()
    measured.idle[number] = idle
    for question in QUESTIONS:
        ours.forget_peak()
        for k in HEAVY:
            ours.ask(question, measured.constants(k), measured.document(question, k, size))
        measured.rows[question.name].memory[number] = ours.peak() - idle


def _ask_lxml(measured: Run, answers: dict[tuple[str, int], Answer]) -> None:
    """Each document is parsed once and asked everything: all trees together would take many gigabytes."""
    largest = measured.library.sizes[max(SIZES)]
    times: dict[tuple[str, int, int], float] = {}
    parts: dict[tuple[str, int], object] = {}
    for document in largest.documents:
        tree = Lxml(largest.file(document))
        for question in QUESTIONS:
            for k in SLOW:
                if not any(
                    _concerns(measured, question, k, size, document) for size in measured.library.sizes.values()
                ):
                    continue
                times[question.name, k, document], found = tree.ask(question, measured.constants(k))
                if k == TIMED[0]:
                    parts[question.name, document] = same_of_one(question, found)
    for number, size in measured.library.sizes.items():
        for question in QUESTIONS:
            totals = []
            for k in SLOW:
                asked = [d for d in size.documents if _concerns(measured, question, k, size, d)]
                totals.append(sum(times[question.name, k, d] for d in asked))
                if k == TIMED[0]:
                    whole = joined(question, [parts[question.name, d] for d in asked])  # type: ignore[misc]  # parts of one question are alike
                    measured.compare(question, f"lxml, {number} documents", whole, answers[question.name, number])
            measured.rows[question.name].lxml[number] = median_ms(totals)


def _concerns(measured: Run, question: Question, k: int, size: Size, document: int) -> bool:
    return measured.document(question, k, size) in (None, document) and document in size.documents


def _ask_postgres(measured: Run, answers: dict[tuple[str, int], Answer]) -> None:
    number = SIZES[0]
    size = measured.library.sizes[number]
    try:
        with postgres(size) as table:
            for question in QUESTIONS:
                times = []
                for k in SLOW:
                    asked, document = measured.constants(k), measured.document(question, k, size)
                    start = time.perf_counter()
                    rows = table.ask(question, asked, document)
                    times.append(time.perf_counter() - start)
                    if k == TIMED[0]:
                        found = table.same(question, rows)
                        measured.compare(question, "PostgreSQL", found, answers[question.name, number])
                measured.rows[question.name].postgres = median_ms(times)
    except RuntimeError as error:
        print(f"   PostgreSQL is left out: {error}")
