"""Additional facts about runs: their number, and the figures of the sample or quantity that the query asks for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice

import numpy as np

from mcml.errors import LimitError
from mcml.motion.bodies.quantities import QUANTITIES, AskedQuantity, compute
from mcml.motion.skeleton import CHANNELS, Array
from mcml_schemas.querying.queries import QueryRequest, RunItem, RunTotals
from mcml_service.clips.frame_quantities import FrameQuantities, is_beside_positions
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.engine.scan_plan import plan_scan
from mcml_service.xpath.language.motion_functions import MOTION_FUNCTIONS, PREFIX
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.rules import normal
from mcml_service.xpath.language.tree import Call, Expression, Literal, children
from mcml_service.xpath.language.unparse import unparse
from mcml_service.xpath.library.caches import Caches
from mcml_service.xpath.nodes.node import Run

MAX_RUNS = 100_000
"""That are counted, or gone past for a later page."""


def counted(found: Iterable[Run]) -> tuple[list[Run], RunTotals]:
    """All runs, and their numbers. LimitError where they are too many to be counted."""
    runs = list(islice(found, MAX_RUNS + 1))
    if len(runs) > MAX_RUNS:
        raise LimitError(f"The result has more than {MAX_RUNS} runs.", remedy="Narrow the query.")
    frames = sum(run.last - run.first + 1 for run in runs)
    return runs, RunTotals(frames=frames, runs=len(runs), documents=len({run.stored.key for run in runs}))


def sample_of(request: QueryRequest) -> tuple[str, int] | None:
    """Return (bone, channel) of the sample that a query compares: the selected one, or else its first bound.

    None if it compares no sample of a named bone.
    """
    plan = plan_scan(normal(parse(request.q, request.variables).tree))
    if plan is None:
        return None
    bounded = [sample for sample, _, _ in plan.condition.bounds]
    for sample in filter(None, [plan.sample, *bounded, *sorted(plan.condition.strict, key=str)]):
        bone = plan.bone if sample.bone is None else sample.bone
        if bone is not None:
            return bone, sample.channel
    return None


def quantity_of(request: QueryRequest) -> AskedQuantity | None:
    """Return the first quantity of bodies in a query whose value is a number, None if there is none."""
    return next(_quantities(normal(parse(request.q, request.variables).tree)), None)


def _quantities(expression: Expression) -> Iterator[AskedQuantity]:
    name = expression.function.removeprefix(PREFIX) if isinstance(expression, Call) else ""
    if isinstance(expression, Call) and expression.function in MOTION_FUNCTIONS and name in QUANTITIES:
        texts = tuple(each.value for each in expression.arguments if isinstance(each, Literal))
        if not QUANTITIES[name].is_truth and texts and len(texts) == len(expression.arguments):
            arguments = tuple(map(str, texts))
            yield AskedQuantity(unparse(expression), name, arguments, QUANTITIES[name].unit)
    for part in children(expression):
        yield from _quantities(part)


def add_figures(
    tx: Transaction,
    caches: Caches,
    request: QueryRequest,
    runs: Sequence[Run],
    items: Sequence[RunItem],
    check: Callable[[], None],
) -> str | None:
    """Add the minimum, maximum and mean of the compared sample to each run, or of the quantity of bodies; return the
    sample as BONE.CHANNEL, or the quantity as in the query.

    check: called often; raises when time is up.
    """
    sample = sample_of(request)
    quantity = quantity_of(request) if sample is None else None
    if sample is None and quantity is None:
        return None
    columns: dict[int, Array] = {}
    for run, item in zip(runs, items, strict=True):
        check()
        if sample is not None:
            values = _read_samples(tx, run, *sample)
        else:
            assert quantity is not None
            key = run.stored.key
            if key not in columns:
                columns = {key: _read_quantity(tx, caches, run.stored, quantity)}
            values = columns[key][run.first - 1 : run.last]
        values = values[~np.isnan(values)]
        if len(values):
            item.range, item.mean = [float(values.min()), float(values.max())], float(values.mean())
    return quantity.text if quantity is not None else f"{sample[0]}.{CHANNELS[sample[1]]}" if sample else None


def _read_samples(tx: Transaction, run: Run, name: str, channel: int) -> Array:
    """(n,) samples of a channel of a bone in a run; none where the document lacks the bone."""
    bones = {bone: number for number, bone in tx.heads.bone_names(run.stored.key).items()}
    if name not in bones:
        return np.empty(0)
    column = (bones[name], channel)
    blocks = tx.tracks.blocks(run.stored.key, run.first, run.last, columns=[column], bones=[bones[name]])
    return np.concatenate([np.empty(0), *(block.values[:, block.columns.index(column)] for block in blocks)])


def _read_quantity(tx: Transaction, caches: Caches, listed: Listed, asked: AskedQuantity) -> Array:
    """(n,) of all frames of a document."""
    body = caches.bodies.read(tx, [listed])[0]
    if is_beside_positions(asked):
        return FrameQuantities(tx, listed, body).read_known(asked)
    return compute(asked.name, asked.arguments, body.stretch(asked.joints(body.names)))
