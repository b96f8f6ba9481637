"""Weights of blend shapes are asked for as other samples are, and as libxml2 answers."""

from __future__ import annotations

from random import Random

import pytest

from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import FACE, MCML, store
from tests.xpath.library import exported
from tests.xpath.oracle import check

pytestmark = pytest.mark.above_store

QUESTIONS = (
    "//frame_bone/@weight",
    "//frame[frame_bone[@name='JawOpen']/@weight > 0.3]",
    "//frame[frame_bone[@name='JawOpen'][@weight > 0.3]]/@id",
    "count(//frame_bone/@weight)",
    "sum(//frame_bone[@name='EyeBlinkLeft']/@weight)",
    "//frame[sum(frame_bone/@weight) > 1]",
    "//frame[not(frame_bone/@weight)]",
    "//frame[frame_bone/@weight < frame_bone/@Rx]",
    "//frame[count(frame_bone[@weight]) = 2]",
    "//frame_bone/@*[. > 0.9]",
    "//frame_bone[@weight = 1.053]/@*",
    "//frame_bone[not(@weight)]/@name",
    "//frame_bone/@*[last()]",
    "//frame_bone[@*[name() = 'weight']]",
    "//frame_bone/@weight/following::frame_bone/@weight",
    "string(//frame[2]/frame_bone[2]/@weight)",
    "//frame[position() mod 2 = 0]/frame_bone/@weight",
    "//bone[@convention='shape']/order",
)


@pytest.mark.parametrize("question", QUESTIONS)
def test_answers_are_libxml2s(database: Database, question: str) -> None:
    store(database, {"face.mcml": FACE, "hand.mcml": MCML})
    engine = Queries(database, Settings(query_seconds=600))
    try:
        outcome = check(engine, dict(exported(database)), question, Random(1), whole=True)
        assert outcome is not None
        assert outcome.filled
    finally:
        engine.close()
