"""The language itself: the paper's names at the paper's places, and what it refuses."""

from __future__ import annotations

from typing import Any

import pytest
from lxml import etree

from mcml.errors import DocumentError
from mcml.language import dtd, vocabulary
from mcml.language.content import declarations
from mcml.language.elements import Element, mcml_element
from mcml.motion.skeleton import CHANNELS
from mcml.resources import dtd_path
from tests.mcml.samples import FIGURES
from tests.mcml.strategies import small_document


def test_the_paper_s_figures_are_valid_in_a_complete_document() -> None:
    dtd.validate(FIGURES)


def _of_file(name: str, *more: Element) -> Element:
    source = Element("source", {"part": "bvh", "name": name, "encoding": "utf-8"})
    header = Element("header", {"format": "bvh"}, children=[Element("filename", text=name), *more, source])
    return mcml_element(header, [Element("skeleton")])


@pytest.fixture
def validated(monkeypatch: pytest.MonkeyPatch) -> list[Element]:
    """The documents that libxml2 was asked about."""
    asked: list[Element] = []

    def validate(document: Element, shapes: Any, names: Any) -> None:
        asked.append(document)
        validate_by_shapes(document, shapes, names)

    validate_by_shapes = dtd.validate_by_shapes
    monkeypatch.setattr(dtd, "validate_by_shapes", validate)
    monkeypatch.setattr(dtd, "_KNOWN_VALID", set())
    return asked


def test_documents_that_differ_in_names_of_files_are_validated_once(validated: list[Element]) -> None:
    shape = ((0, 0b111000),)
    for number in range(3):
        dtd.validate_often(_of_file(f"walk & {number}.bvh"), [(shape, 1)], ["Root"])
    assert len(validated) == 1
    dtd.validate_often(_of_file("walk.bvh"), [(((0, 0b111),), 1)], ["Root"])
    dtd.validate_often(_of_file("walk.bvh", Element("version", text="1")), [(shape, 1)], ["Root"])
    assert len(validated) == 3


@pytest.mark.parametrize(
    "bad",
    [
        Element("filename", text="twice"),
        Element("version", {"no": "such"}, "1"),
        Element("version", text="\x01"),
        Element("version", {}, "1", [Element("version")]),
        Element("calibration_units", text="cm"),
    ],
)
def test_what_is_like_a_valid_document_and_is_not_valid_is_refused(bad: Element, validated: list[Element]) -> None:
    for good in (Element("version", text="1"), Element("calibration_unit", text="cm")):
        dtd.validate_often(_of_file("walk.bvh", good), [], [])
    for _ in range(2):
        with pytest.raises(DocumentError):
            dtd.validate_often(_of_file("walk.bvh", bad), [], [])
    assert len(validated) == 4


def test_words_between_which_the_dtd_lets_choose_are_compared(validated: list[Element]) -> None:
    def document(mapped: str) -> Element:
        bone = Element("bone", {"mapped": mapped}, children=[Element("name", text="chest")])
        return mcml_element(Element("header"), [Element("skeleton", children=[bone])])

    dtd.validate_often(document("true"), [], ["chest"])
    with pytest.raises(DocumentError, match="mapped"):
        dtd.validate_often(document("perhaps"), [], ["chest"])


TABLE_2 = (
    "filetype datatype filename version skeleton_name units num_segments num_frames dataframe_rate "
    "euler_rotation_order calibration_unit global_axis_of_gravity bone_length_axis scale_factor"
)
TABLE_3 = "name direction length position axis order dof limits bodymass cofmass"


def test_every_name_of_the_paper_s_tables_stands_where_the_paper_has_it() -> None:
    declared = declarations()
    held = {name: {tag for step in model.steps for tag in step} for name, model in declared.items()}
    assert set(TABLE_2.split()) <= held["header"]
    assert {"mass", "length", "angle"} <= set(declared["units"].attributes)
    assert {"order", "axis", "position", "orientation"} <= set(declared["root"].attributes)
    assert "bone" in held["skeleton"]
    assert set(TABLE_3.split()) <= held["bone"]
    assert "id" in declared["bone"].attributes
    assert "id" in declared["frame"].attributes
    assert {"frames", "frametime", "frame"} <= held["motion"]
    assert {"motion_name", "frame_bone"} <= held["frame"]
    assert {"name", "Tx", "Ty", "Tz", "Rx", "Ry", "Rz"} <= set(declared["frame_bone"].attributes)


def test_the_vocabulary_is_the_dtd_s() -> None:
    words = {word for word in vars(vocabulary).values() if isinstance(word, str)} | set(vocabulary.HEADER_LEAVES)
    assert set(declarations()) <= words
    assert {vocabulary.NAME, *CHANNELS} == set(declarations()["frame_bone"].attributes)
    assert set(vocabulary.UNIT_ATTRIBUTES) <= set(declarations()["units"].attributes)


def test_the_dtd_has_no_any_no_entities_no_ids_and_no_defaults() -> None:
    with dtd_path().open("rb") as file:
        parsed: Any = etree.DTD(file)
    assert not list(parsed.iterentities())
    for element in parsed.iterelements():
        assert element.type in ("element", "empty", "mixed")
        for attribute in element.iterattributes():
            assert attribute.type in ("cdata", "enumeration")
            assert attribute.default in ("required", "implied")


def test_a_violation_has_its_line() -> None:
    document = small_document().replace(b"<frames>2</frames>", b"")
    (violation, *_) = dtd.violations(document)
    assert violation.at is not None
    assert violation.at.line == document[: document.index(b"<motion>")].count(b"\n") + 1
    with pytest.raises(DocumentError, match="motion"):
        dtd.validate(document)
