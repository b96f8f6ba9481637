"""Readable cases: the expected answer, libxml2's, that of the pool of processes, and that of the plan."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from service.xpath.evaluate import Evaluator, Nodes
from service.xpath.parse import parse
from service.xpath.plan import COUNT, EXISTS, Plan, plan
from tests.xpath.small import DOCUMENT, answer, tree


@dataclass(frozen=True)
class Case:
    expression: str
    lines: tuple[str, ...]

    @property
    def expected(self) -> list[str]:
        return [line for line in self.lines if line not in ("planned", "not planned")]

    def check(self, value: Any) -> None:
        """value: a scalar, or (address, value) of each node."""
        if isinstance(value, list):
            found = [f"{address} = {text}" for address, text in value] or ["nothing"]
            assert len(found) == len(self.expected)
            for got, wanted in zip(found, self.expected, strict=True):
                assert got == wanted if " = " in wanted else got.partition(" = ")[0] == wanted
            return
        kind, _, text = self.expected[0].partition(" ")
        if isinstance(value, bool):
            assert (kind, text) == ("boolean", str(value).lower())
        elif isinstance(value, str):
            assert (kind, text) == ("string", value)
        else:
            wanted = float(text.replace("Infinity", "inf"))
            assert kind == "number"
            assert math.isnan(value) if math.isnan(wanted) else value == wanted


def cases() -> Iterator[Case]:
    for path in sorted((Path(__file__).parent / "cases").glob("*.txt")):
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
        for block in "\n".join(lines).strip().split("\n\n"):
            expression, *answers = block.splitlines()
            yield Case(expression, tuple(line.strip() for line in answers))


CASES = list(cases())


@pytest.fixture(scope="module")
def pool() -> Iterator[Evaluator]:
    evaluator = Evaluator(processes=1)
    yield evaluator
    evaluator.close()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.expression)
def test_the_pool_answers_as_expected(case: Case, pool: Evaluator) -> None:
    assert case.expected
    found = pool.evaluate(parse(case.expression), [DOCUMENT.encode()])
    case.check([(node.address, node.value) for node in found.items] if isinstance(found, Nodes) else found.value)


@pytest.mark.parametrize("case", [case for case in CASES if case.expression != "/"], ids=lambda case: case.expression)
def test_libxml2_agrees(case: Case) -> None:
    case.check(answer(tree(), parse(case.expression).text))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.expression)
def test_plans(case: Case) -> None:
    found = plan(parse(case.expression).tree)
    if "planned" in case.lines:
        assert found is not None
    if "not planned" in case.lines:
        assert found is None
    if found is not None:
        case.check(run_slowly(found))


def run_slowly(found: Plan) -> Any:
    """What a plan means, the obvious way, on the parsed document."""
    document = tree()
    frames = document.xpath("/mcml/motion/frame")
    if found.position is not None:
        frames = frames[found.position - 1 : found.position]
    for group in found.motion_names:
        frames = [frame for frame in frames if {name.text for name in frame.findall("motion_name")} & set(group)]
    if found.nth is not None:
        frames = frames[found.nth - 1 : found.nth]
    paths = [document.getpath(frame) for frame in frames]
    if found.bones:
        bones = [bone for frame in frames for bone in list(frame.findall("frame_bone"))[_one(found.ordinal)]]
        paths = [document.getpath(bone) for bone in bones if found.bone in (None, bone.get("name"))]
    if found.attribute is not None:
        paths = [f"{path}/@{found.attribute}" for path in paths if document.xpath(f"{path}/@{found.attribute}")]
    paths = paths[_one(found.nth_result)]
    if found.aggregate == COUNT:
        return float(len(paths))
    if found.aggregate == EXISTS:
        return bool(paths)
    return [item for path in paths for item in answer(document, path)]


def _one(place: int | None) -> slice:
    return slice(None) if place is None else slice(place - 1, place)


def test_pages_and_totals(pool: Evaluator) -> None:
    found = pool.evaluate(parse("//frame/@id"), [DOCUMENT.encode()], limit=2, offset=3)
    assert isinstance(found, Nodes)
    assert [node.value for node in found.items] == ["4", "5"]
    assert found.total == 6
