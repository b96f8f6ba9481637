"""Each analysis of the catalogue keeps the contract that `mcml_service.testing` has for others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.dance.analyses import BEATS, DANCE, MOTION_GRAPH
from mcml_service.analysis.expression_space.analyses import EXPRESSION
from mcml_service.analysis.gait.analyses import GAIT
from mcml_service.analysis.interface import Motion, Parts
from mcml_service.analysis.reach_blending.analyses import REACH
from mcml_service.testing import AnalysisContract
from tests.analysis.dance.motions import generated as dance
from tests.analysis.expression.face_motions import motions as faces
from tests.analysis.gait.walks import Walk
from tests.analysis.reach.reach_motions import generated as reaches
from tests.laboratory.walkers import Gait as WalkerOf


class TestReach(AnalysisContract):
    analysis = REACH
    wishes: ClassVar = {"synthesize": {"attributes": {"age": 25, "height": 168, "hbp": 270}}}

    def motions(self) -> Sequence[Motion]:
        return reaches()[0]


class TestExpression(AnalysisContract):
    analysis = EXPRESSION

    def motions(self) -> Sequence[Motion]:
        return faces(fps=6, every_marker=8)


class TestBeats(AnalysisContract):
    analysis = BEATS

    def motions(self) -> Sequence[Motion]:
        return [dance("groove", "1")[0], dance("hit", "2")[0]]


class TestMotionGraph(TestBeats):
    analysis = MOTION_GRAPH


class TestDance(TestBeats):
    analysis = DANCE
    parameters: ClassVar = {"bpm": 112}


class TestGait(AnalysisContract):
    analysis = GAIT

    def motions(self) -> Sequence[Any]:
        return [Walk("1", WalkerOf()), Walk("2", WalkerOf(stride_time=1.3)), Walk("3", None)]

    def test_the_same_motions_give_the_same_result(self, first_run: tuple[Parts, list[float]]) -> None:
        assert self.run(self.motions()) == first_run[0]


def test_each_analysis_has_its_contract() -> None:
    contracts = (TestReach, TestExpression, TestBeats, TestMotionGraph, TestDance, TestGait)
    assert {contract.analysis.name for contract in contracts} == set(ANALYSES)
