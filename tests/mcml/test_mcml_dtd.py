"""The language itself: the paper's names at the paper's places, and what it refuses."""

from __future__ import annotations

import copy
from typing import Any

import pytest
from lxml import etree

from service.errors import DocumentError
from service.mcml import dtd, vocabulary
from service.mcml.content import declarations
from service.resources import dtd_path
from tests.mcml.strategies import small_document

HEADER = """<header> <filetype> htr </filetype> <datatype> HTRS </datatype> <filename> quickwalk.htr </filename>
  <version> 1.0 </version> <skeleton_name> Billy </skeleton_name> <units mass="1.0" length="0.45" angle="degree"/>
  <num_frames> 60 </num_frames> </header>"""
SKELETON = """<root order="Tx Ty Tz Rx Ry Rz" axis="XYZ" position="0 0 0" orientation="0 0 0"/> <skeleton> <bone id="1">
  <name> l femur </name> <direction> 0.34202 0.939693 0 </direction> <length> 6.8845 </length>
  <axis> 0 0 20 XYZ </axis> <dof> rx ry rz </dof> <limits> -160.0 20.0 </limits> <limits> -70.0 70.0 </limits>
  <limits> 60.0 70.0 </limits> <bone id="2"> <name> l tibia </name> <bone id="3"> <name> l foot </name> </bone> </bone>
  </bone> </skeleton>"""
MOTION = """<motion> <frames> 89 </frames> <frametime> 0.3333 </frametime> <frame id="1">
  <motion_name> left-arm-front </motion_name> <frame_bone name="hips" Tx="-5.61" Ty="37.37" Tz="-68.55" Rx="-1.9"
  Ry="4.16" Rz="-5.28"/> <frame_bone name="chest" Tx="-5.61" Ty="37.37" Tz="-68.55" Rx="-1.9" Ry="4.16" Rz="-5.28"/>
  </frame> </motion>"""


def test_the_paper_s_figures_are_valid_in_a_complete_document() -> None:
    dtd.validate(f'<mcml version="1.0">{HEADER}{SKELETON}{MOTION}</mcml>'.encode())


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
    kinds: dict[str, set[str]] = {"elements": set(), "text": set(), "empty": set()}
    for name, declaration in declarations().items():
        kinds[declaration.kind].add(name)
    assert kinds["elements"] == vocabulary.ELEMENT_CONTENT
    assert kinds["text"] == vocabulary.LEAVES
    assert kinds["empty"] == vocabulary.EMPTY
    assert tuple(sorted(vocabulary.FRAME_BONE_ATTRIBUTES)) == tuple(sorted(declarations()["frame_bone"].attributes))
    for tag in ("root", "bone"):
        assert set(vocabulary.JOINT_ATTRIBUTES) <= set(declarations()[tag].attributes)


def test_the_dtd_has_no_any_no_entities_no_ids_and_no_defaults() -> None:
    with dtd_path().open("rb") as file:
        parsed: Any = etree.DTD(file)
    assert not list(parsed.iterentities())
    for element in parsed.iterelements():
        assert element.type in ("element", "empty", "mixed")
        for attribute in element.iterattributes():
            assert attribute.type in ("cdata", "enumeration")
            assert attribute.default in ("required", "implied")


REQUIRED = {"header", "skeleton", "motion", "name", "frames", "mcml"}
"""Elements that a content model asks for wherever it mentions them."""


def _mutants(document: bytes) -> list[tuple[str, etree._Element]]:
    """Every document with one required element removed, renamed, or swapped with a neighbour of another tag."""
    mutants = []
    root = etree.fromstring(document)
    for place, node in enumerate(root.iter()):
        if node.tag not in REQUIRED:
            continue
        for kind in ("remove", "rename", "rename to a neighbour", "swap forward", "swap back"):
            tree = copy.deepcopy(root)
            target = list(tree.iter())[place]
            parent = target.getparent()
            other = None
            if parent is not None:
                index = parent.index(target) + (1 if kind != "swap back" else -1)
                other = parent[index] if 0 <= index < len(parent) else None
            if kind == "rename":
                target.tag = f"{target.tag}_"
            elif parent is None:
                continue
            elif kind == "remove":
                parent.remove(target)
            elif other is None or other.tag == target.tag:
                continue
            elif kind == "rename to a neighbour":
                target.tag = other.tag
            else:
                parent.insert(parent.index(other), target) if kind == "swap back" else parent.insert(
                    parent.index(target), other
                )
            mutants.append((f"{kind} {node.tag}", tree))
    return mutants


def test_documents_with_a_required_element_removed_renamed_or_swapped_are_refused() -> None:
    document = small_document()
    dtd.validate(document)
    mutants = _mutants(document)
    accepted = [what for what, tree in mutants if not dtd.violations(etree.tostring(tree))]
    assert len(mutants) >= 25
    assert len(accepted) <= 0.05 * len(mutants), accepted


def test_neighbours_of_another_tag_can_nowhere_be_swapped_but_bones_and_end_sites() -> None:
    root = etree.fromstring(small_document())
    accepted = set()
    count = 0
    for place, node in enumerate(root.iter()):
        following = node.getnext()
        if following is None or following.tag == node.tag:
            continue
        tree = copy.deepcopy(root)
        target = list(tree.iter())[place]
        parent = target.getparent()
        parent.insert(parent.index(target), target.getnext())
        count += 1
        if not dtd.violations(etree.tostring(tree)):
            accepted.add((node.tag, following.tag))
    assert count > 25
    assert accepted <= {("bone", "end_site"), ("end_site", "bone")}


def test_a_violation_has_its_line() -> None:
    document = small_document().replace(b"<frames>2</frames>", b"")
    (violation, *_) = dtd.violations(document)
    assert violation.at is not None
    assert violation.at.line == document[: document.index(b"<motion>")].count(b"\n") + 1
    with pytest.raises(DocumentError, match="motion"):
        dtd.validate(document)
