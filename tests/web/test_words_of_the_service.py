"""The studio has words for every kind of problem and every stage of a job that the service tells, in each language."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import mcml_service
from mcml.errors import kind_name
from mcml_service.actions.checking.describe_problem import STATUS_OF, PreconditionError, problem_of
from mcml_service.jobs.runner import STARTING
from mcml_service.jobs.telling import BEGUN

UI = Path(__file__).parents[2] / "service" / "web" / "src" / "ui"
LANGUAGES = 3


def stages() -> Iterator[str]:
    """Every stage that the program gives to a progress."""
    yield from (STARTING, BEGUN, "waiting", "cancelling")
    for file in Path(mcml_service.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_bytes())):
            is_progress = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "progress"
            if is_progress and isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
                yield str(node.args[0].value)


def test_every_kind_of_problem_has_a_title() -> None:
    text = (UI / "problems" / "words.ts").read_text(encoding="utf-8")
    refused = PreconditionError("stale", 412, remedy="Read it again.")
    title = problem_of(refused).title
    assert f'"label.problem_{kind_name(type(refused))}": "{title}"' in text
    for kind in STATUS_OF:
        assert text.count(f'"label.problem_{kind_name(kind)}"') == LANGUAGES, kind


def test_every_stage_of_a_job_has_a_word() -> None:
    text = (UI / "analyses" / "words.ts").read_text(encoding="utf-8")
    told = set(stages())
    assert len(told) > 20
    for stage in told:
        assert text.count(f'"label.stage_{stage.replace(" ", "_")}"') == LANGUAGES, stage
