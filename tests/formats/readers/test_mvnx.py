"""MVNX files: places and rotations of segments as they are written."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mcml.errors import FormatError, LimitError, McmlError
from mcml.files.gather_files import recognise
from mcml.formats.format import Limits
from mcml.motion.skeleton import Array
from mcml.testing import frames
from tests.builders import source
from tests.formats.readers.posing import places_of, read_clip, reads_or_refuses, spoil

SEGMENTS = ("Pelvis", "L5", "RightUpperLeg")
OFFSETS = np.array([[0, 0, 0], [0, 0, 0.1], [0, -0.1, 0]])


def row(values: Array) -> str:
    return " ".join(f"{value:.9f}" for value in np.ravel(values))


def poses(frames: int = 5, seed: int = 0) -> tuple[Array, Rotation]:
    """(frames, 3, 3) places and the rotations of the frames, one after the other."""
    chance = np.random.default_rng(seed)
    turns = Rotation.from_rotvec(np.cumsum(chance.normal(0, 0.2, (frames, 3, 3)), axis=0).reshape(-1, 3))
    root = chance.normal(0, 1, (frames, 3))
    pelvis = turns[::3]
    places = np.stack([root, root + pelvis.apply(OFFSETS[1]), root + pelvis.apply(OFFSETS[2])], axis=1)
    return places, turns


def mvnx(places: Array, turns: Rotation, *, positions: bool = True, rest: str = "tpose") -> bytes:
    def frame(kind: str, at: Array, turned: Array) -> str:
        where = f"<position>{row(at)}</position>" if positions else ""
        turns = f"<orientation>{row(turned)}</orientation>"
        return f'<frame type="{kind}" tc="01:02:03:04" ms="17">{turns}{where}</frame>'

    quaternions = turns.as_quat(scalar_first=True).reshape(len(places), 3, 4)
    listed = "".join(f'<segment label="{name}" id="{number}"><points>'
                     f'<point label="j{name}"><pos_b>0 0 0</pos_b></point>'
                     + ("".join(f'<point label="j{other}"><pos_b>{row(OFFSETS[place])}</pos_b></point>'
                                for place, other in enumerate(SEGMENTS)) if name == "Pelvis" else "")
                     + "</points></segment>" for number, name in enumerate(SEGMENTS, 1))  # fmt: skip
    joints = "".join(
        f"<joint><connector1>Pelvis/j{name}</connector1><connector2>{name}/j{name}</connector2></joint>"
        for name in SEGMENTS[1:]
    )
    still = frame(rest, OFFSETS, np.tile([1.0, 0, 0, 0], (3, 1)))
    moving = "".join(frame("normal", at, turned) for at, turned in zip(places, quaternions, strict=True))
    return (
        f'<?xml version="1.0"?><!-- Xsens --><mvnx xmlns="http://www.xsens.com/mvn/mvnx" version="4">'
        f'<subject label="a" frameRate="60"><segments>{listed}</segments><joints>{joints}</joints>'
        f"<frames>{still}{moving}</frames></subject></mvnx>"
    ).encode()


@pytest.mark.parametrize("rest", ["identity", "tpose", "npose", "tpose-isb"])
@pytest.mark.parametrize("seed", range(3))
def test_segments_stand_where_the_file_has_them(rest: str, seed: int) -> None:
    places, turns = poses(9, seed)
    clip = read_clip("mvnx", mvnx(places, turns, rest=rest))
    assert np.abs(places_of(clip) - places).max() < 2e-8
    assert any("no calibration pose" in notice.what for notice in clip.notices) == (rest == "tpose-isb")
    assert clip.head.properties == (("timecode", "01:02:03:04", ""), ("recorded", "17", ""))
    assert clip.head.fields["dataframe_rate"] == "60"


def test_without_positions_segments_follow_from_points() -> None:
    places, turns = poses()
    clip = read_clip("mvnx", mvnx(places, turns, positions=False))
    assert np.abs(places_of(clip) - (places - places[:, :1])).max() < 1e-7
    assert any("no positions" in notice.what for notice in clip.notices)


def test_the_file_is_recognised_as_xml_of_its_own() -> None:
    assert recognise(source("a.xml", mvnx(*poses()))) == ("mvnx", "mvnx")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((b"</orientation>", b" 1</orientation>"), "orientations of the frame in line 1 are not 12 numbers"),
        ((b'type="normal"', b'type="npose"'), "no frames of motion"),
        ((b"L5/jL5", b"L6/jL6"), "which are no segments"),
        ((b"Pelvis/jL5", b"L5/jL5"), "its own ancestors"),
        ((b"</frames>", b""), "damaged or cut off"),
        ((b'frameRate="60"', b'frameRate="fast"'), "no frame rate"),
        ((b'label="L5" id', b'label="Pelvis" id'), "two segments are called"),
    ],
)
def test_what_is_wrong_is_told(change: tuple[bytes, bytes], message: str) -> None:
    with pytest.raises(FormatError, match=message):
        frames(read_clip("mvnx", mvnx(*poses()).replace(*change)))


def test_entities_and_limits() -> None:
    data = mvnx(*poses())
    bomb = b'<?xml version="1.0"?><!DOCTYPE mvnx [<!ENTITY a "b">]>' + data.split(b"-->", 1)[1].replace(
        b"Pelvis", b"&a;", 1
    )
    with pytest.raises(McmlError):
        frames(read_clip("mvnx", bomb))
    for limits in (Limits(frames=2), Limits(joints=2), Limits(depth=1)):
        with pytest.raises(LimitError):
            frames(read_clip("mvnx", data, limits=limits))


def test_any_byte_may_be_wrong() -> None:
    data = mvnx(*poses(2))
    chance = np.random.default_rng(5)
    for _ in range(100):
        reads_or_refuses("mvnx", spoil(data, chance))


def contacts_of(content: bytes) -> tuple[list[tuple[str, ...]], list[str]]:
    """The labels of the frames, and the notices."""
    clip = read_clip("mvnx", content)
    names = [labels for block in clip.blocks() for labels in block.motion_names or [()] * len(block)]
    return names, [notice.what for notice in clip.notices]


DEFINED = ("LeftFoot_Heel", "LeftFoot_Toe", "RightFoot_Heel", "RightFoot_Toe")


def with_contacts(rows: list[str], defined: tuple[str, ...] = DEFINED) -> bytes:
    """A file with these contacts in its frames."""
    content = mvnx(*poses(len(rows))).decode()
    still, *moving = content.split('<frame type="normal"')
    made = [
        part.replace("</frame>", f"<footContacts>{row}</footContacts></frame>", 1)
        for part, row in zip(moving, rows, strict=True)
    ]
    listed = "".join(f'<contactDefinition label="{label}" index="{place}"/>' for place, label in enumerate(defined))
    still = still.replace("<frames>", f"<footContactDefinition>{listed}</footContactDefinition><frames>")
    return '<frame type="normal"'.join([still, *made]).encode()


@pytest.mark.parametrize("defined", [DEFINED, ()])
def test_contacts_are_labels(defined: tuple[str, ...]) -> None:
    names, notices = contacts_of(with_contacts(["1 1 0 0", "0 0 0 0", "", "0 1 0 1"], defined))
    assert names == [("contact-left-heel", "contact-left-toe"), (), (), ("contact-left-toe", "contact-right-toe")]
    assert any("the contacts of the feet are labels: contact-left-heel" in what for what in notices)


def test_contacts_of_other_parts_have_the_names_of_their_definition() -> None:
    names, _ = contacts_of(with_contacts(["1 0", "0 1"], ("RightHand", "left foot")))
    assert names == [("contact-right-hand",), ("contact-left",)]


@pytest.mark.parametrize("rows", [["1 1 1", "0 0 0"], ["1 1 0 0", "0 0"], ["1 0.5 1 1", "1 0.5 1 1"]])
def test_contacts_that_do_not_fit_their_definition_are_left_out(rows: list[str]) -> None:
    names, notices = contacts_of(with_contacts(rows))
    assert names == [()] * 2
    assert any("contacts of the feet do not fit" in what for what in notices)
