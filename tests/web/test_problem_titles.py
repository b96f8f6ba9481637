"""The studio has a title for every kind of problem that the service answers, in each language."""

from __future__ import annotations

from pathlib import Path

from mcml.errors import kind_name
from mcml_service.actions.checking.describe_problem import STATUS_OF, PreconditionError, problem_of

WORDS = Path(__file__).parents[2] / "service" / "web" / "src" / "ui" / "problems" / "words.ts"
LANGUAGES = 3


def test_every_kind_of_problem_has_a_title() -> None:
    text = WORDS.read_text(encoding="utf-8")
    refused = PreconditionError("stale", 412, remedy="Read it again.")
    title = problem_of(refused).title
    assert f'"label.problem_{kind_name(type(refused))}": "{title}"' in text
    for kind in STATUS_OF:
        assert text.count(f'"label.problem_{kind_name(kind)}"') == LANGUAGES, kind
