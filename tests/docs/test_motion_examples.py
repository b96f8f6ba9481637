"""Every question of docs/motion.md, on the people of the demo library, against a loop over the frames."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest

from mcml.motion.bodies.limb_angles import angle_names
from mcml_schemas.querying.queries import NodeItem, QueryRequest
from mcml_service.actions.importing.load_demo import load_demo
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS
from mcml_service.xpath.queries import Queries
from tests.xpath.motion_twin import Asked, Document, Node, best_runs, read_documents

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "motion.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"^\| ([^|`]+) \| `(.+)` \|$", TEXT[TEXT.index("## Twenty-five") :], re.MULTILINE)
NOTHING = "nobody turns in the demo library"
Twin = Callable[[Sequence[Document]], list[Node] | float]
Holds = Callable[[Document, int], bool]


def frames(holds: Holds) -> Twin:
    return lambda documents: [one.address(frame) for one in documents for frame in where(one, holds)]


def runs(holds: Holds, least: float, gap: float = 0.0) -> Twin:
    return lambda documents: [
        one.address(frame) for one in documents for frame in one.long_runs(where(one, holds), least, gap)
    ]


def best(count: int, holds: Holds, key: Callable[[Document, int], float] | None = None) -> Twin:
    asked = None if key is None else Asked("key", key)
    return lambda documents: best_runs([fresh(one) for one in documents], Asked("holds", holds), count, asked)


def files(holds: Callable[[Document], bool]) -> Twin:
    return lambda documents: [(one.uuid, "/mcml/header/filename") for one in documents if holds(one)]


def where(document: Document, holds: Holds) -> list[int]:
    return [frame for frame in range(len(document.frames)) if holds(document, frame)]


def fresh(document: Document) -> Document:
    """Without what was asked under the same words."""
    document.kept = {key: kept for key, kept in document.kept.items() if key not in ("key", "holds")}
    return document


def of(name: str, *arguments: str) -> Callable[[Document, int], float]:
    return lambda document, frame: document.quantity(name, *arguments)[frame]


def rise(document: Document, frame: int) -> float:
    heights = document.quantity("height", "Root")
    return heights[frame] - min(heights[other] for other in document.window(frame, -1.0, 0.0, by_frames=False))


def turn(document: Document, frame: int) -> bool:
    headings = document.quantity("heading")
    before = document.window(frame, -1.0, -1.0, by_frames=False)
    return bool(before) and headings[frame] - headings[before[0]] > 90


def before_lowering(document: Document, frame: int) -> bool:
    name = "left-arm-adduction"
    soon = any(name in document.frames[o].names for o in document.window(frame, 0.0, 1.0, by_frames=False))
    return soon and name not in document.frames[frame].names


def mean_speed(documents: Sequence[Document]) -> float:
    speeds = [one.quantity("speed", "Root")[n] for one in documents for n in where(one, named("walk"))]
    return math.fsum(speeds) / len(speeds)


def named(name: str) -> Holds:
    return lambda document, frame: name in document.frames[frame].names


def like(documents: Sequence[Document], stretch: tuple[int, int] | None) -> list[Node]:
    """The five best places that are like a frame, or a stretch, of a walk."""
    (other,) = (one for one in documents if one.name == "walk_1")

    def apart(document: Document, frame: int) -> float:
        if stretch is None:
            return document.pose_distances(other, 120)[frame]
        return document.motion_distances(other, *stretch)[frame]

    return best(5, lambda d, n: apart(d, n) < 0.1, lambda d, n: -apart(d, n))(documents)  # type: ignore[return-value]


hand, head, knee = of("height", "left_hand"), of("height", "Head"), of("angle", "left-knee-flexion")
toes, other_toes = of("contact", "left_toes"), of("contact", "right_toes")
toe_height, left, right = (
    of("height", "left_toes"), of("angle", "left-arm-abduction"), of("angle", "right-arm-abduction"),
)  # fmt: skip
TWINS: list[Twin] = [
    frames(lambda d, n: hand(d, n) > head(d, n)),
    frames(lambda d, n: knee(d, n) > 45),
    frames(lambda d, n: toe_height(d, n) < 0.05),
    frames(lambda d, n: rise(d, n) > 0.02),
    frames(lambda d, n: of("speed", "right_hand")(d, n) > 2),
    frames(before_lowering),
    best(1, named("walk")),
    lambda documents: like(documents, None),
    lambda documents: like(documents, (100, 160)),
    best(1, named("reach"), of("speed", "right_hand", "Root")),
    runs(lambda d, n: knee(d, n) > 10, 0.5),
    runs(lambda d, n: toe_height(d, n) > 0.02 and not (toes(d, n) == 1 or other_toes(d, n) == 1), 0.1),
    runs(lambda d, n: (toes(d, n) == 1) != (other_toes(d, n) == 1), 0.1, 0.02),
    frames(turn),
    frames(lambda d, n: of("distance", "left_hand", "right_hand")(d, n) < 0.65),
    frames(lambda d, n: of("position", "left_hand", "left", "Root")(d, n) < 0.35),
    frames(lambda d, n: of("tilt", "Root", "neck1")(d, n) > 5),
    frames(lambda d, n: left(d, n) > 15 and right(d, n) > 15),
    frames(lambda d, n: d.rates(Asked("knee", knee))[n] < -200),
    mean_speed,
    files(lambda d: (len(d.frames) - 1) * d.seconds > 3),
    frames(lambda d, n: toe_height(d, n) > 0.1 * of("leg")(d, n)),
    frames(lambda d, n: of("acceleration", "right_hand")(d, n) > 30),
    frames(lambda d, n: of("angle", "trunk-flexion")(d, n) > 3 and knee(d, n) < 20),
    files(lambda d: not d.quantity("leg")[0] > 0),
]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Queries, list[Document]]]:
    database = Database(f"sqlite:///{tmp_path_factory.mktemp('demo') / 'store.db'}")
    database.migrate()
    load_demo(database, Settings(), ["people"])
    queries = Queries(database, Settings())
    yield queries, read_documents(database)
    queries.close()
    database.close()


def test_there_are_twenty_five() -> None:
    assert len(EXAMPLES) == len(TWINS) == 25


@pytest.mark.slow
@pytest.mark.parametrize("place", range(25), ids=[words for words, _ in EXAMPLES])
def test_questions(place: int, library: tuple[Queries, list[Document]]) -> None:
    engine, documents = library
    (words, text), wanted = EXAMPLES[place], TWINS[place](library[1])
    answer = engine.answer(QueryRequest(q=text, limit=1000))
    if isinstance(wanted, float):
        assert answer.value == pytest.approx(wanted, rel=1e-12)
        return
    found = []
    while True:
        found += [(item.document, item.address) for item in answer.items or [] if isinstance(item, NodeItem)]
        if answer.next_cursor is None:
            break
        answer = engine.answer(QueryRequest(q=text, limit=1000, cursor=answer.next_cursor))
    assert found == wanted
    assert (not found) == (NOTHING in words)
    frames = sum(len(one.frames) for one in documents)
    assert len(found) < frames * 0.7


def test_every_function_is_explained_with_its_unit() -> None:
    units_without = {"nodes": "frames", "boolean": "true, false", "number": "as in the file"}
    rows = re.findall(r"^\| (`mo:.+) \| [^|]+ \| ([^|]+) \|$", TEXT, re.MULTILINE)
    found = {}
    for calls, unit in rows:
        for name, parameters in re.findall(r"`(mo:[\w-]+)\(([^`]*)\)`", calls):
            function = MOTION_FUNCTIONS[name]
            assert function.least <= len(re.findall(r"[^,]+", parameters)) <= len(function.parameters), name
            found[name] = unit
    assert set(found) == set(MOTION_FUNCTIONS)
    for name, function in MOTION_FUNCTIONS.items():
        assert found[name] == (function.unit or units_without[function.result])


def test_the_angles_that_are_named_are_there() -> None:
    table = TEXT[TEXT.index("| angle | computed from |") : TEXT.index("While you type")]
    named = re.findall(r"`([a-z-]+-[a-z-]+)`", table)
    assert len(named) > 15
    for name in named:
        assert name in angle_names() or f"left-{name}" in angle_names(), name
