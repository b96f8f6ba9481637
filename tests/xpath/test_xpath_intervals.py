"""What zone maps rule out no frame fulfils, and what they make certain every frame does."""

from __future__ import annotations

from random import Random

import numpy as np

from mcml_service.xpath.engine.columns import Columns
from mcml_service.xpath.engine.samples.condition import Condition
from mcml_service.xpath.engine.samples.kernel import fulfilled
from mcml_service.xpath.language.conditions import Sample, condition
from mcml_service.xpath.language.parse import parse
from mcml_service.xpath.language.rules import normal
from mcml_service.xpath.language.tree import Path
from mcml_service.xpath.library.intervals import Interval
from mcml_service.xpath.nodes.numbering import Bools, Floats
from tests.xpath.test_xpath_scan import Maker

TRACKS, FRAMES = 40, 6


def test_verdicts_hold_in_every_frame() -> None:
    random, rng = Random(3), np.random.default_rng(3)
    columns = Columns(None)  # type: ignore[arg-type]  # conditions look at no document
    maker = Maker(random, ["a", "b"])
    compiled = ruled_out = certain = 0
    for _ in range(1500):
        tree = normal(parse(f"//frame[{maker.condition('frame')}]").tree)
        assert isinstance(tree, Path)
        made = [condition(predicate, "frame") for predicate in tree.steps[-1].predicates]
        if len(made) != 1 or made[0] is None:
            continue
        compiled += 1
        asked = Condition.of(made[0])
        block: dict[Sample, Floats] = {}
        ends: dict[Sample, Interval] = {}
        for sample in asked.samples:
            middle = rng.choice([0, 5, 10.5, -20, 45.5, 1e308], (TRACKS, 1))
            values: Floats = middle + rng.choice([0, 0.5, 30], (TRACKS, 1)) * rng.integers(-1, 2, (TRACKS, FRAMES))
            values[rng.random(TRACKS) < 0.1] = np.nan
            values[(rng.random(TRACKS) < 0.2)[:, None] & (rng.random((TRACKS, FRAMES)) < 0.3)] = np.nan
            present: Bools = ~np.isnan(values)
            low, high = np.where(present, values, np.inf).min(axis=1), np.where(present, values, -np.inf).max(axis=1)
            some, always = np.asarray(present.any(axis=1)), np.asarray(present.all(axis=1))
            low[~some] = high[~some] = np.nan
            block[sample] = values
            ends[sample] = Interval(low, high, some, always)
        holds = fulfilled(columns, asked.tree, block)
        with np.errstate(all="ignore"):
            verdict = asked.judge(ends)
        assert not holds[~verdict.may].any()
        assert holds[verdict.must].all()
        ruled_out += int((~verdict.may).sum())
        certain += int(verdict.must.sum())
    assert compiled > 500
    assert ruled_out > 5000
    assert certain > 2000
