"""Every operation that the API describes, asked at random with ids that exist: no failure, and nothing undescribed.

Schemathesis makes requests of the description, as it allows them and as it does not; `Library` puts what the store
holds in place of most of their ids, names, frames and files, so that they get past "there is no document".
"""

from __future__ import annotations

import re
import traceback
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from random import Random
from typing import Any

import pytest
import requests
import schemathesis
from fastapi.testclient import TestClient
from hypothesis import Phase, given, seed, settings
from hypothesis import strategies as st
from hypothesis.errors import FlakyStrategyDefinition
from hypothesis.internal.conjecture.data import ConjectureData
from hypothesis.stateful import initialize
from schemathesis import Case, GenerationMode
from schemathesis.core.failures import FailureGroup
from schemathesis.core.parameters import ParameterLocation
from schemathesis.core.transport import Response
from schemathesis.generation.stateful.state_machine import APIStateMachine, StepInput, StepOutput
from schemathesis.schemas import APIOperation
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import description, served
from tests.hostile.library import FILES, Library

BASE = "http://127.0.0.1:8000"
CHECKS = [status_code_conformance, content_type_conformance, response_schema_conformance]
SETTINGS = Settings(query_seconds=2.0, import_processes=1, max_frames=100_000, query_memory_mib=256)
REFILL = 6
"""Operations between two looks at what there is."""
TOGETHER = 3
"""Scenarios that Hypothesis makes in one go; the first is the shortest that there is."""
FOREIGN = re.compile(
    r"<class '|NoneType|object has no|Value error|array element|codec can't|parsing the body|Traceback|ndarray"
)
"""What an exception of a library says of itself, and no problem of ours."""
OPERATIONS = sorted(
    (found.ok() for found in schemathesis.openapi.from_dict(description()).get_all_operations()),
    # What takes away comes last.
    key=lambda operation: operation.method == "delete",
)


def send(client: TestClient, case: Case) -> Any:
    """The answer to a request as Schemathesis writes it; what it raises is raised here. None: no client sends it."""
    prepared = requests.Request(**_sendable(case)).prepare()
    if len(str(prepared.url)) > 60_000:
        return None
    headers = {name: value for name, value in prepared.headers.items() if name.lower() not in ("content-length",)}
    return client.request(
        str(prepared.method), str(prepared.url), headers=headers, content=prepared.body, follow_redirects=False
    )


def _sendable(case: Case) -> dict[str, Any]:
    known = ("method", "url", "params", "headers", "json", "data", "files")
    words = {name: item for name, item in case.as_transport_kwargs(base_url=BASE).items() if name in known}
    if case.media_type == "application/xml" and isinstance(case.body, str):
        # Schemathesis would put it into an element as text.
        words["data"] = case.body.encode("utf-8", "surrogatepass")
    if words.get("files"):
        words["files"] = [
            (name, (content, FILES[content]) if content in FILES else (stated, content))
            for name, (stated, content, *_) in words["files"]
        ]
    return words


def faults(case: Case, answer: Any) -> list[str]:
    """What is wrong with an answer."""
    text = answer.text if "octet-stream" not in answer.headers.get("content-type", "") else ""
    found: list[str] = []
    if FOREIGN.search(text if answer.status_code >= 400 else ""):
        found.append(f"the words of a foreign exception: {text[:300]}")
    if answer.status_code == 503 and "retry-after" not in answer.headers:
        found.append("503 without Retry-After")
    if answer.status_code >= 500 and answer.status_code not in (503, 507):
        return [*found, f"{answer.status_code}: {text[:300]}"]
    events = answer.headers.get("content-type", "").startswith("text/event-stream")
    try:
        # A description of this version has no words for the parts of events.
        case.validate_response(answer, checks=CHECKS[:2] if events else CHECKS)
    except FailureGroup as group:
        found += [f"{type(failure).__name__}: {failure}" for failure in group.exceptions]
    return found


@dataclass
class Campaign:
    """Requests of every operation; wrong: what went wrong, each with the first request that showed it. links: how
    many followed from an answer."""

    client: TestClient
    library: Library
    wrong: dict[str, str] = field(default_factory=dict)
    statuses: Counter[int] = field(default_factory=Counter)
    links: int = 0

    def run(self, number: int, examples: int, operations: list[APIOperation]) -> None:
        for place, operation in enumerate(operations):
            if place % REFILL == 0:
                self.library.refill()
            modes = {mode: operation.as_strategy(generation_mode=mode) for mode in GenerationMode}
            seldom = st.sampled_from([GenerationMode.POSITIVE] * 4 + [GenerationMode.NEGATIVE])
            cases = seldom.flatmap(lambda mode, modes=modes: st.tuples(st.just(mode), modes[mode], st.data()))
            # Nothing is raised in it: the store has changed, and the same request would have another answer.
            random = given(cases)(self._ask)
            chosen = settings(max_examples=examples, database=None, derandomize=False, phases=[Phase.generate])
            seed(number)(chosen(random))()

    def _ask(self, made: tuple[GenerationMode, Case, st.DataObject]) -> None:
        mode, case, data = made
        if mode is GenerationMode.POSITIVE:
            self.library.fill(case, data.draw)
        self.ask(case)

    def ask(self, case: Case) -> Any:
        """The answer to a request, None where there is none."""
        answer = None
        try:
            answer = send(self.client, case)
            if answer is None:
                return None
            self.statuses[answer.status_code] += 1
            found = faults(case, answer)
        except Exception as error:
            frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "/service/" in frame.filename]
            found = [f"{type(error).__name__} in {frames[-1:]}: {error}"]
        for fault in found:
            request = f"{case.path_parameters} {case.query} {case.headers} {str(case.body)[:600]}"
            self.wrong.setdefault(f"{case.operation.label}: {fault[:500]}", request)
        return answer


def workflow(asked: Campaign) -> type[APIStateMachine]:
    """Requests that take what answers before them gave: a document that was stored is read, changed, deleted, read.

    Schemathesis finds in the description which operation needs what another one answers.
    """

    class Workflow(schemathesis.openapi.from_dict(description()).as_state_machine()):  # type: ignore[misc]
        @initialize(number=st.integers(0, 2**32))
        def _begin(self, number: int) -> None:
            # What a store holds is no choice of Hypothesis: the same one would find other documents the next time.
            chance = Random(number)
            self._draw = lambda strategy: ConjectureData(prefix=(), random=chance).draw(strategy)
            asked.library.refill()

        def step(self, input: StepInput) -> StepOutput | None:
            case, linked = input.case, {place for place, _ in input.applied_parameters}
            if not linked or case.path.endswith("/events"):
                asked.library.fill(case, self._draw)
            elif linked == {ParameterLocation.PATH}:
                asked.library.fill_contents(case, self._draw)
            asked.links += bool(linked)
            answer = asked.ask(case)
            return None if answer is None else StepOutput(Response.from_any(answer), case)

    return Workflow


@contextmanager
def campaign(database: Database, analyses: dict[str, Any]) -> Iterator[Campaign]:
    """Whatever goes wrong in it fails in the end, and the store has to be sound."""
    # The client is not entered: jobs wait, and no worker has to be started.
    client = served(database, SETTINGS, base_url=BASE)
    asked = Campaign(client, Library(client, database, SETTINGS, analyses))
    try:
        yield asked
    finally:
        client.app.state.repository.queries.close()  # type: ignore[attr-defined]
    assert not asked.wrong, "\n\n".join(f"{fault}\n  {request}" for fault, request in asked.wrong.items())
    assert database.check(past=True) == []


@pytest.mark.slow
def test_a_few_requests_of_each_operation(database: Database, kind: str) -> None:
    """Each is asked of one kind of database; `make fuzz` asks all of both."""
    with campaign(database, {"reach": {"components": 2}}) as asked:
        asked.run(1, 1, OPERATIONS[kind == "sqlite" :: 2])
    good = sum(count for status, count in asked.statuses.items() if status < 300)
    assert good > asked.statuses.total() / 5, asked.statuses


@pytest.mark.slow
@pytest.mark.above_store
def test_a_few_requests_that_follow_each_other(database: Database) -> None:
    with campaign(database, {"reach": {"components": 2}}) as asked:
        follow(asked, 1, scenarios=3, steps=20)
    assert asked.links > 1


@pytest.mark.fuzz(seeds=3)
def test_requests_that_follow_each_other(database: Database, seed: int) -> None:
    with campaign(database, {"reach": {"components": 2}, "expression": {}}) as asked:
        follow(asked, seed, scenarios=100, steps=40)
    assert asked.statuses.keys() >= {200, 201, 204, 404, 422}, asked.statuses


def follow(asked: Campaign, number: int, *, scenarios: int, steps: int) -> None:
    machine = workflow(asked)
    few = settings(max_examples=TOGETHER, stateful_step_count=steps, database=None, derandomize=False)
    for part in range(0, scenarios, TOGETHER):
        # It is no fault that the store is another one by then: what Hypothesis began alike goes on in another way.
        with suppress(FlakyStrategyDefinition):
            seed(number + part)(machine).run(settings=settings(few, phases=[Phase.generate]))


@pytest.mark.fuzz(seeds=3)
def test_every_operation_of_the_description(database: Database, seed: int) -> None:
    with campaign(database, {"reach": {"components": 2}, "expression": {}}) as asked:
        asked.run(seed, 120, OPERATIONS)
    statuses = asked.statuses
    assert statuses.keys() >= {200, 201, 202, 204, 404, 409, 412, 422}, statuses
