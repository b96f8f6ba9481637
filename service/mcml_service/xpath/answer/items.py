"""Values, nodes and runs as a page shows them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from mcml_schemas.querying.queries import NodeItem, QueryAnswer, RunItem, ScalarItem
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.tree import Atomic
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.nodes.frame_runs import IdRuns
from mcml_service.xpath.nodes.node import Node, Run

Kind = Literal["nodes", "runs", "number", "string", "boolean", "strings", "values"]


def scalars(kind: Kind, documents: Sequence[Listed], found: Sequence[Atomic]) -> QueryAnswer:
    """One value of one document, or a value of each."""
    if len(documents) == 1:
        return QueryAnswer(type=kind, value=plain(found[0]))
    items = [
        ScalarItem(document=listed.uuid, revision=listed.revision, value=plain(value))
        for listed, value in zip(documents, found, strict=True)
    ]
    return QueryAnswer(type=kind, items=list(items))


def kind_of_value(value: Atomic) -> Kind:
    if isinstance(value, bool):
        return "boolean"
    return "string" if isinstance(value, str) else "number"


def run_items(tx: Transaction, caches: Caches, runs: Sequence[Run]) -> list[RunItem]:
    """Runs as an answer shows them, their frame ids read together."""
    documents = {run.stored.key: run.stored for run in runs}
    place = {key: number for number, key in enumerate(documents)}
    ends = [(place[run.stored.key] << 48) | (end << 24) for run in runs for end in (run.first, run.last)]
    numbers, others = IdRuns(caches.ids.read(tx, list(documents.values()))).numbers(np.array(ends, np.int64))
    ids = [others.get(index, str(number)) for index, number in enumerate(numbers.tolist())]
    return [
        RunItem(
            document=run.stored.uuid,
            name=run.stored.name,
            revision=run.stored.revision,
            first=run.first,
            last=run.last,
            first_id=first_id,
            last_id=last_id,
            frames=run.last - run.first + 1,
        )
        for run, first_id, last_id in zip(runs, ids[::2], ids[1::2], strict=True)
    ]


def node_item(node: Node) -> NodeItem:
    return NodeItem.model_construct(
        kind=node.kind,  # type: ignore[arg-type]  # one of them
        document=node.stored.uuid,
        revision=node.stored.revision,
        address=node.address,
        value=node.value,
    )


def plain(value: Atomic) -> Atomic:
    """JSON has no NaN and no infinities: they are the texts that XPath's string() gives."""
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value
