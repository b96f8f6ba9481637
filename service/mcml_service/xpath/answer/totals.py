"""Additional facts about runs: their number, and the range of the compared sample."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice

import numpy as np

from mcml.errors import LimitError
from mcml.motion.skeleton import CHANNELS
from mcml_schemas.querying.queries import QueryRequest, RunItem, RunTotals
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.engine.scan_plan import plan_scan
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.rules import normal
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


def add_ranges(tx: Transaction, request: QueryRequest, runs: Iterable[Run], items: Iterable[RunItem]) -> str | None:
    """Add the range of the compared sample to each run; return the sample as BONE.CHANNEL."""
    sample = sample_of(request)
    if sample is None:
        return None
    name, channel = sample
    for run, item in zip(runs, items, strict=True):
        bones = {bone: number for number, bone in tx.heads.bone_names(run.stored.key).items()}
        if name not in bones:
            continue
        column = (bones[name], channel)
        ends: list[float] = []
        for block in tx.tracks.blocks(run.stored.key, run.first, run.last, columns=[column], bones=[bones[name]]):
            values = block.values[:, block.columns.index(column)]
            values = values[~np.isnan(values)]
            if len(values):
                ends += [float(values.min()), float(values.max())]
        if ends:
            item.range = [min(ends), max(ends)]
    return f"{name}.{CHANNELS[channel]}"
