"""Quantities of motions in files are those that XPath has of the same motions in a store."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import mcml
from mcml.errors import NotFoundError, RequestError
from mcml_service.actions.importing.load_demo import demo_files

ASKED = {
    "mo:height('left_hand')": lambda walk: walk.height("left_hand"),
    "mo:position('Head', 'front')": lambda walk: walk.position("Head", "front"),
    "mo:position('Head', 'x', 'Root')": lambda walk: walk.position("Head", "x", "Root"),
    "mo:distance('left_hand', 'right_hand')": lambda walk: walk.distance("left_hand", "right_hand"),
    "mo:angle('left-knee-flexion')": lambda walk: walk.angle("left-knee-flexion"),
    "mo:angle('left-forearm-pronation')": lambda walk: walk.angle("left-forearm-pronation"),
    "mo:angle('left_up_leg', 'left_low_leg', 'left_foot')": lambda walk: walk.angle(
        "left_up_leg", "left_low_leg", "left_foot"
    ),
    "mo:tilt('Root', 'Head')": lambda walk: walk.tilt("Root", "Head"),
    "mo:speed('right_hand')": lambda walk: walk.speed("right_hand"),
    "mo:speed('right_hand', 'Root')": lambda walk: walk.speed("right_hand", "Root"),
    "mo:acceleration('right_hand')": lambda walk: walk.acceleration("right_hand"),
    "mo:heading()": lambda walk: walk.heading(),
    "mo:contact('left_foot')": lambda walk: walk.contact("left_foot"),
    "mo:activity('walk')": lambda walk: walk.activity("walk"),
}


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    files = demo_files()
    path = tmp_path_factory.mktemp("walk") / "walk.bvh"
    path.write_bytes(files["walk.bvh"])
    return path


@pytest.fixture(scope="module")
def repo(walk: Path) -> Iterator[mcml.Repository]:
    with mcml.open(walk.with_name("store.db")) as repo:
        repo.import_(walk)
        yield repo


@pytest.mark.parametrize("expression", ASKED)
def test_a_file_answers_as_the_store_does(walk: Path, repo: mcml.Repository, expression: str) -> None:
    alone = ASKED[expression](mcml.read(walk))
    stored = repo.xpath(f"//frame/{expression}").value()
    np.testing.assert_array_equal(alone, np.array(stored, np.float64))
    assert np.isfinite(alone).any()


def test_a_unit_that_is_stated_scales_what_is_in_metres(walk: Path) -> None:
    halved = mcml.read(walk, unit="mm").height("Head")
    np.testing.assert_allclose(mcml.read(walk, unit="cm").height("Head"), 10 * halved, rtol=1e-3)
    assert mcml.read(walk, unit="mm").calibration.origins["metres"].kind == "stated"


def test_what_is_not_there_is_refused(walk: Path) -> None:
    with pytest.raises(NotFoundError, match="no bone 'tail'"):
        mcml.read(walk).height("tail")
    with pytest.raises(RequestError, match="no axis"):
        mcml.read(walk).position("Head", "sideways")
