"""How many generated expressions are answered without projection: from indexes and columns, not from XML."""

from __future__ import annotations

import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random

from mcml.errors import LimitError, QueryError
from mcml_schemas.querying.queries import QueryRequest
from mcml_service.storage.database import Database
from mcml_service.xpath.language.parse import parse
from tests.conftest import shared_folder
from tests.xpath.grammar import Grammar
from tests.xpath.library import Library, library
from tests.xpath.oracle import most_elements
from tests.xpath.xpath2_grammar import Xpath2Grammar

EXPRESSIONS = 2000
WANTED = 0.95


def run() -> dict[str, object]:
    """Shares of expressions of XPath 1.0 and 2.0, by way."""
    with tempfile.TemporaryDirectory() as folder:
        database = Database(f"sqlite:///{Path(folder) / 'store.db'}")
        database.migrate()
        with library(database, shared_folder()) as made:
            figures: dict[str, object] = {
                "XPath 1.0": _shares("XPath 1.0", made, Grammar),
                "XPath 2.0": _shares("XPath 2.0", made, Xpath2Grammar),
            }
        database.close()
    return figures


def _shares(version: str, made: Library, kind: type[Grammar]) -> dict[str, float]:
    random = Random(11)
    ways: Counter[str] = Counter()
    start = time.perf_counter()
    elements = {uuid: sum(1 for _ in tree.iter()) for uuid, tree in made.trees.items()}
    for uuid, text in kind(random, made.trees).expressions():
        query = parse(text)
        if query.is_later != (version == "XPath 2.0"):
            # The grammar of 2.0 makes some of 1.0 as well.
            continue
        small = [other for other, size in elements.items() if size <= most_elements(query.tree)]
        documents = small if random.random() < 0.1 else [uuid if uuid in small else random.choice(small)]
        try:
            explain = made.engine.answer(QueryRequest(q=text, document=documents, explain=True)).explain
        except QueryError:
            # Saxon refuses some while they run.
            continue
        except LimitError:
            ways["limit"] += 1
            continue
        if explain is not None:
            ways[explain.way] += 1
        if ways.total() == EXPRESSIONS:
            break
    seconds = time.perf_counter() - start
    shares = {way: count / EXPRESSIONS for way, count in sorted(ways.items())}
    without = shares.get("index", 0) + shares.get("columns", 0)
    goal = f" (wanted: {WANTED:.0%} or more)" if version == "XPath 1.0" else ""
    print(f"{version}: {EXPRESSIONS} expressions in {seconds:.1f} s, {without:.1%} without projection{goal}; {shares}")
    return {**shares, "without projection": without}
