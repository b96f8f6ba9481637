"""What a rig writes around its names changes nothing; nor does any text make it fail."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml.motion.rigs.recognise import recognise
from mcml.motion.rigs.tree import Tree
from mcml.motion.rigs.words import read_words
from tests.fuzz import examples
from tests.motion.rigs.rig_builder import CORE, USUAL, mirrored, names_of, person


def _parted(name: str, mark: str) -> str:
    """A name whose words are parted by a mark instead of capitals."""
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return re.sub(r"[_ \-]+", mark, parted)


def _side_last(name: str) -> str:
    """A name whose word for the side stands at the end."""
    bare = name.rpartition(":")[2]
    match = re.match(r"(.*?)(left|right|(?<![a-z])[lr](?=[_\W])|(?<![A-Za-z])[lr](?=[A-Z]))(.*)", bare, re.I | re.S)
    if match is None:
        return name
    before, side, after = match.groups()
    return f"{(before + after).strip('_. -')}_{side}"


DISGUISES: Mapping[str, Callable[[str, int], str]] = {
    "prefix": lambda name, _: f"Actor01_{name}",
    "namespace": lambda name, _: f"ns:{name}",
    "path": lambda name, _: f"group|body|{name}",
    "suffix": lambda name, _: f"{name}_JNT",
    "copy": lambda name, _: f"{name}.001",
    "counter": lambda name, place: f"{name}_{place}",
    "capitals": lambda name, _: _parted(name, "_").upper(),
    "small letters": lambda name, _: _parted(name, "_").lower(),
    "only capitals": lambda name, _: name.upper(),
    "only small letters": lambda name, _: name.lower(),
    "side last": lambda name, _: _side_last(name),
    "blanks": lambda name, _: _parted(name, " "),
    "dashes": lambda name, _: _parted(name, "-"),
    "no separators": lambda name, _: re.sub(r"[\W_]", "", name),
}
UNREAL = mirrored(
    {"Root": "pelvis", "waist": "spine_01", "torso2": "spine_02", "torso7": "spine_03", "neck1": "neck_01",
     "Head": "head", "left_shoulder": "clavicle_l", "left_up_arm": "upperarm_l", "left_low_arm": "lowerarm_l",
     "left_hand": "hand_l", "left_up_leg": "thigh_l", "left_low_leg": "calf_l", "left_foot": "foot_l",
     "left_toes": "ball_l"},
    [("_l", "_r")],
)  # fmt: skip
BIPED = mirrored(
    {"Root": "Bip01 Pelvis", "waist": "Bip01 Spine", "torso7": "Bip01 Spine1", "neck1": "Bip01 Neck",
     "Head": "Bip01 Head", "left_shoulder": "Bip01 L Clavicle", "left_up_arm": "Bip01 L UpperArm",
     "left_low_arm": "Bip01 L Forearm", "left_hand": "Bip01 L Hand", "left_up_leg": "Bip01 L Thigh",
     "left_low_leg": "Bip01 L Calf", "left_foot": "Bip01 L Foot", "left_toes": "Bip01 L Toe0"},
    [(" L ", " R ")],
)  # fmt: skip


@given(st.sampled_from([USUAL, UNREAL, BIPED]), st.sampled_from(sorted(DISGUISES)), st.booleans())
def test_disguises_change_nothing(names: dict[str, str], disguise: str, lengths: bool) -> None:
    rig = person(names, lengths=lengths)
    change = DISGUISES[disguise]
    changed = replace(rig, names=[change(name, place) for place, name in enumerate(rig.names)])
    assert names_of(rig, recognise(changed)) == names


@examples(60)
@given(st.lists(st.text(max_size=12), max_size=20), st.data())
def test_any_names_in_any_tree_are_read(names: list[str], data: st.DataObject) -> None:
    words = st.sampled_from(["LeftArm", "L_leg", "hand", "Hips", "spine", "Head", "左足", "foot_r", "thumb", "x"])
    names = [data.draw(st.one_of(st.just(name), words)) for name in names]
    parents = [data.draw(st.integers(-1, place - 1)) for place in range(len(names))]
    places = data.draw(
        st.lists(st.tuples(*[st.floats(-1e3, 1e3)] * 3), min_size=len(names), max_size=len(names)).map(np.array)
    )
    found = recognise(Tree(names, parents, np.asarray(places, float).reshape(-1, 3)))
    assert len({each.joint for each in found.joints}) == len({each.name for each in found.joints}) == len(found.joints)
    assert all(0 < each.confidence <= 1 for each in found.joints)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("mixamorig:LeftForeArm", "left forearm"),
        ("lhipjoint", "l hipjoint"),
        ("左手首", "左 手首"),
        ("r_larm", "r l arm"),
        ("LUArm", "l u arm"),
        ("NPC L Hand [LHnd]", "npc l hand"),
        ("ＩＫ_foot", "ik foot"),
        ("Schlüsselbein", "schlusselbein"),
        ("a|b|upperArm.L", "upperarm l"),
        ("왼쪽팔", "왼쪽 팔"),
    ],
)
def test_names_are_split_into_words(name: str, words: str) -> None:
    (own, *_), _ = read_words([name, "Hips", "Spine", "Head"])
    assert " ".join(word.text for word in own) == words


def test_the_language_of_a_rig_decides_on_short_words() -> None:
    french = ["tete", "cou", "bassin", "cuisse_g", "cuisse_d", "genou_g", "genou_d", "main_g", "main_d", "coude_g"]
    assert read_words(french)[1] == "fr"
    assert read_words(["Hips", "Spine", "main", "LeftHand"])[1] == "en"


def test_rigs_of_the_shared_list_are_complete(shared: Path) -> None:
    """26 rigs by the names that they are known by; the dog among them has no limbs in the list."""
    rigs = json.loads((shared / "names" / "rigs_dev.json").read_text(encoding="utf-8"))
    for rig, names in rigs.items():
        found = names_of(person(names))
        if rig.startswith("animal"):
            assert found == {}, rig
        else:
            wanted = names if rig != "mmm_kit" else {name: own for name, own in names.items() if name in CORE}
            assert {name: found.get(name) for name in wanted} == wanted, rig
            assert not {name: own for name, own in found.items() if names.get(name, own) != own}, rig
