"""ASF and AMC: the contract, and every quirk of real files."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest

from mcml.errors import ConversionError, FormatError, LimitError
from mcml.formats import FORMATS
from mcml.formats.format import Limits, ReadOptions
from mcml.motion.clip import ClipStream
from mcml.testing import FormatContract, frames, read, written
from tests.builders import ASF as LEG
from tests.builders import amc

AMC = """#!OML:ASF X:\\file.ASF
:FULLY-SPECIFIED
:DEGREES
1
root 9.37216 17.8693 -17.3198 -2.01677 -7.59696 -3.41767
lfemur -0.3 2.5 -1e-015
ltibia 15.5
2
root 9.4 17.9 -17.2 -2 -7.5 -3.4
lfemur 0 -0 .5
ltibia 16.5
"""
NAME = "asf-amc"
ASF = LEG.decode()


def clip_of(asf: str = ASF, amc: str | None = AMC, **options: object) -> ClipStream:
    files = {"asf": asf.encode()} | ({} if amc is None else {"amc": amc.encode()})
    return read(FORMATS[NAME], files, ReadOptions(**options))  # type: ignore[arg-type]


def notices(asf: str = ASF, amc: str | None = AMC) -> str:
    clip = clip_of(asf, amc)
    frames(clip)
    return "\n".join(notice.what for notice in clip.notices)


class TestAsfAmc(FormatContract):
    name = NAME
    samples: ClassVar = {
        "basic": {"asf": ASF.encode(), "amc": AMC.encode()},
        "sparse": {
            "asf": ASF.encode(),
            "amc": b"17\nltibia 1\nroot 1 2 3 4 5 6\n18\n19\nLFEMUR 1 2 3\nltibia 2\n007\nroot 0 0 0 0 0 0\n",
        },
        "latin": {"asf": ASF.encode(), "amc": AMC.replace("X:", "X:\\für").encode("latin-1")},
        "odd": {
            "asf": b":namespace a b\nfree text\n:root\naxis ZYX\norder RX RY RZ TX TY TZ\n:bonedata\nbegin\nname a\n"
            b"length 0\ndirection 0 0 0\naxis 1 2 3 zyx\ndof tx rz rx ry l\nlimits (-inf inf) (0 0)\nbodymass 1.5\n"
            b"cofmass .5\nend\n:hierarchy\nbegin\nroot a\nend\n:skin x.skin\n",
            "amc": b":RADIANS\n-3\nroot 1 2 3 4 5 6\na 1 2 3 4 5\n",
        },
    }

    def test_an_asf_alone_is_a_clip_without_frames(self) -> None:
        clip = clip_of(amc=None)
        assert (frames(clip), clip.frames) == ([], 0)
        assert written(self.format, clip)["asf"] == written(self.format, clip_of())["asf"]


def test_keeps_what_the_file_says() -> None:
    clip = clip_of()
    root, hip, femur, tibia = clip.head.skeleton.joints
    assert clip.head.skeleton.declared == (0, 2, 1, 3)
    assert [joint.parent for joint in clip.head.skeleton.joints] == [-1, 0, 1, 2]
    assert (femur.direction, femur.length, femur.axis) == (("0.34202", "-0.939693", "0"), "7.34031", ("0", "0", "20"))
    assert (femur.limits, femur.id) == (("-160.0 20.0", "-70.0 70.0", "-60.0 70.0"), "2")
    assert (femur.channels, femur.rotation_order, hip.channels) == (("Rx", "Ry", "Rz"), "XYZ", ())
    assert (root.channels[:3], root.offset, root.axis) == (("Tx", "Ty", "Tz"), ("0", "0", "0"), ("0", "0", "0"))
    assert tibia.rotation_order == "X"
    assert clip.head.fields == {
        "version": "1.10", "skeleton_name": "leg", "units_mass": "1.0", "units_length": "0.45", "units_angle": "deg",
    }  # fmt: skip
    asf, amc = clip.head.sources
    assert asf.comments == ("# a comment",)
    assert asf.sections == ((":documentation", "   # kept as it is\n   two lines"),)
    assert (amc.comments, amc.flags) == (("#!OML:ASF X:\\file.ASF",), (":FULLY-SPECIFIED", ":DEGREES"))
    assert clip.head.frame_time is None
    assert [block.ids.tolist() for block in clip.blocks()] == [[1, 2]]  # type: ignore[union-attr]


def test_numbers_keep_every_bit() -> None:
    block = next(iter(clip_of().blocks()))
    assert block.values[0, 8] == -1e-15
    assert np.signbit(block.values[1, 7])
    assert block.values[1, 8] == 0.5


def test_comments_among_the_frames_are_told_of() -> None:
    kept = AMC.replace(":DEGREES\n", ":DEGREES # unit\n# before the frames\n")
    clip = clip_of(amc=kept)
    assert clip.head.sources[1].comments == ("#!OML:ASF X:\\file.ASF", "# unit", "# before the frames")
    assert "among the frames" not in notices(amc=kept)
    commented = kept.replace("\n1\n", "\n1 # first\n").replace("\n2\n", "\n# between\n2\n") + "# end"
    assert "3 comments among the frames are not in the document; the kept file has them" in notices(amc=commented)
    clip = clip_of(amc=commented)
    assert frames(clip) == frames(clip) == frames(clip_of())
    assert sum("among the frames" in notice.what for notice in clip.notices) == 1


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("  XYZ\n", "\n"),
        lambda text: text.replace("axis 0 0 20", "axis 0, 0, 20").replace("(-160.0 20.0)", "-160.0 20.0"),
        lambda text: text.replace("(-160.0 20.0)\n           (-70.0 70.0)", "(-160.0 20.0) (-70.0 70.0)"),
        lambda text: text.replace("     id 2\n     name lfemur\n", "     name lfemur # the thigh\n     id 2\n"),
        lambda text: text.replace("dof rx ry rz", "DOF RX RY RZ").replace("begin", "BEGIN").replace(":root", ":ROOT"),
        lambda text: text.replace("root lhipjoint", "ROOT lhipjoint").replace("lfemur ltibia", "LFEMUR ltibia"),
    ],
)
def test_accepts_every_spelling(change) -> None:  # type: ignore[no-untyped-def]
    assert frames(clip_of(change(ASF))) == frames(clip_of())
    assert clip_of(change(ASF)).head.skeleton == clip_of().head.skeleton


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("  XYZ\n", "\n"), "bone 'lfemur': axis names no order, read as XYZ"),
        (("length 7.34031", "length 7.34031 (meter)"), "bone 'lfemur': 'meter' behind length is ignored"),
        (("length 0.45", "length 0.45 inch"), "units: 'inch' behind length is ignored"),
        (("    limits (-10.0 170.0)\n", ""), "bone 'ltibia' has 0 limits for 1 degrees of freedom"),
        ((":documentation", ":namespace"), "section :namespace is kept"),
        (("     id 3\n", "     colour red\n"), "bone '?': 'colour' is unknown and ignored"),
        (("   order TX TY TZ RX RY RZ\n", ""), "the root states no order"),
        (("orientation 0 0 0", "orientation 0 90 0"), "rotated in the rest pose"),
        (("dof rx ry rz", "dof rz ry rx"), "dof order ZYX and axis order XYZ differ; dof is taken"),
    ],
)
def test_says_what_it_guessed(change: tuple[str, str], message: str) -> None:
    assert change[0] in ASF
    assert message in notices(ASF.replace(change[0], change[1], 1))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((":root", ":roott"), "ASF section :root is missing"),
        ((":bonedata", ":bones"), "ASF section :bonedata is missing"),
        ((":hierarchy", ":tree"), "ASF section :hierarchy is missing"),
        (("direction 0.34202 -0.939693 0", "direction 0.34 0"), "direction of bone 'lfemur' needs 3 numbers, found 2"),
        (("direction 0.34202 -0.939693 0", "direction 0 0 -0.0"), "bone 'lfemur': direction is the zero vector"),
        (("     direction 0.34202 -0.939693 0\n", ""), "bone 'lfemur' has no direction"),
        (("     length 7.34031\n", ""), "bone 'lfemur' has no length"),
        (("axis 0 0 20", "axis 0 0 x"), "axis of bone 'lfemur': 'x' is not a finite number"),
        (("20  XYZ", "20 XXZ"), "axis order 'XXZ' is not a permutation of XYZ"),
        (("dof rx ry rz", "dof rx rw rz"), "unknown degree of freedom 'rw'"),
        (("dof rx ry rz", "dof rx rx rz"), "degree of freedom 'rx' occurs twice"),
        (("(-160.0 20.0)", "(-160.0 wide)"), "limits of bone 'lfemur': 'wide' is not a finite number"),
        (("name lhipjoint", "name lfemur"), "bone 'lfemur' is defined twice"),
        (("name lhipjoint", "name root"), "a bone is called root"),
        (("     name lhipjoint\n", ""), "a bone has no name"),
        (("    dof rx\n    limits (-10.0 170.0)\n  end\n", ""), "bone 'ltibia' opened at line 35 is not closed"),
        (("lfemur ltibia", "lfemur lknee"), "hierarchy: unknown bone 'lknee'"),
        (("lfemur ltibia", "lfemur lhipjoint"), "bone 'lhipjoint' has two parents"),
        (("    lfemur ltibia\n", ""), "bone 'ltibia' is not in the hierarchy"),
        (("root lhipjoint\n", "root ltibia\n"), "bone 'ltibia' has two parents"),
        (("    root lhipjoint\n    lhipjoint lfemur\n    lfemur ltibia\n",
          "    root ltibia\n    lhipjoint lfemur\n    lfemur lhipjoint\n"), "cycle at 'lfemur'"),
        (("root lhipjoint", "root root"), "the root has a parent"),
        (("angle deg", "angle grad"), "units angle: found 'grad', expected deg or rad"),
        (("length 0.45", "length x"), "units length: 'x' is not a finite number"),
        ((":version 1.10\n", ":version 1.10\n:root\n"), "section :root occurs twice"),
        (("# a comment", "a comment"), "expected a section such as :version, found 'a comment'"),
    ],
)  # fmt: skip
def test_refuses_skeletons(change: tuple[str, str], message: str) -> None:
    assert change[0] in ASF
    with pytest.raises(FormatError) as error:
        clip_of(ASF.replace(change[0], change[1], 1))
    assert message in str(error.value)
    assert error.value.at is not None
    assert error.value.at.line is not None
    assert error.value.at.file == "clip.asf"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("ltibia 16.5", "ltibia 16.5 1"), "frame 2: bone 'ltibia' has 2 values, ASF dof lists 1"),
        (("ltibia 16.5", "lhipjoint 1 2 3"), "frame 2: bone 'lhipjoint' has 3 values, ASF dof lists 0"),
        (("ltibia 16.5", "rtibia 16.5"), "frame 2: bone 'rtibia' is not in the ASF"),
        (("ltibia 16.5", "lfemur 1 2 3"), "frame 2: bone 'lfemur' occurs twice"),
        (("ltibia 16.5", "ltibia 1x"), "frame 2, bone 'ltibia', value 1: '1x' is not a finite number"),
        (("ltibia 16.5", "ltibia nan"), "'nan' is not a finite number"),
        (("ltibia 16.5", "ltibia 1,5"), "'1,5' uses a decimal comma"),
        (("ltibia 16.5", "ltibia 1.5-2"), "two numbers without a space"),
        (("ltibia 16.5", "ltibia"), "bone 'ltibia' has 0 values"),
        (("1\nroot", "one\nroot"), "expected a frame number, found 'one'"),
        (("1\nroot", "root"), "expected a frame number, found 'root"),
    ],
)
def test_refuses_motion(change: tuple[str, str], message: str) -> None:
    assert change[0] in AMC
    with pytest.raises(FormatError) as error:
        frames(clip_of(amc=AMC.replace(change[0], change[1], 1)))
    assert message in str(error.value)
    assert error.value.at is not None
    assert error.value.at.line is not None
    assert error.value.at.file == "clip.amc"


def test_amc_needs_its_asf_and_frames() -> None:
    with pytest.raises(FormatError, match="AMC needs its ASF skeleton"):
        read(FORMATS[NAME], {"amc": AMC.encode()})
    with pytest.raises(FormatError, match="holds no frame"):
        clip_of(amc=":DEGREES\n")


def test_the_line_of_a_bad_row_is_named() -> None:
    with pytest.raises(FormatError) as error:
        frames(clip_of(amc=AMC.replace("ltibia 16.5", "ltibia")))
    assert error.value.at is not None
    assert error.value.at.line == 11


def test_sparse_frames_keep_their_bones_and_their_order() -> None:
    amc = "1\nroot 1 2 3 4 5 6\nltibia 9\n3\nLTIBIA 8\nroot 1 2 3 4 5 7\n"
    clip = clip_of(amc=amc)
    found = frames(clip)
    assert [frame_id for frame_id, _ in found] == [1, 3]
    assert [[joint for joint, _ in bones] for _, bones in found] == [[0, 3], [3, 0]]
    text = "\n".join(notice.what for notice in clip.notices)
    assert "frame numbers do not rise by one: 3 follows 1" in text
    assert "2 frames leave out bones that move; such a bone keeps its last value" in text
    assert written(FORMATS[NAME], clip)["amc"].decode().endswith(amc.replace("LTIBIA", "ltibia"))


def test_frame_ids_are_kept_as_written() -> None:
    clip = clip_of(amc=AMC.replace("\n2\nroot", "\n+02\nroot"))
    assert [frame_id for frame_id, _ in frames(clip)] == ["1", "+02"]
    assert b"\n+02\nroot" in written(FORMATS[NAME], clip)["amc"]


@pytest.mark.slow
def test_regular_and_irregular_frames_give_the_same() -> None:
    """The fast way of regular frames against the slow one, which a comment in every block forces."""
    rng = np.random.default_rng(5)
    rows = []
    for number, (a, b, c) in enumerate(zip(*(rng.normal(size=(6000, k)).round(4) for k in (6, 3, 1)), strict=True), 5):
        rows.append(f"{number}\nroot {' '.join(map(repr, a.tolist()))}\nlfemur {' '.join(map(repr, b.tolist()))}")
        rows.append(f"ltibia {float(c[0])!r}")
    plain = "\n".join(rows)
    commented = "\n".join(row + (" # x" if place % 50 == 7 else "") for place, row in enumerate(rows))
    fast, slow = frames(clip_of(amc=plain)), frames(clip_of(amc=commented))
    assert len(fast) == 6000
    assert fast == slow


def test_no_frame_rate_is_assumed() -> None:
    assert clip_of().head.seconds_per_frame() is None
    assert "states no frame rate" in notices()


def test_limits() -> None:
    with pytest.raises(LimitError, match="name is longer"):
        clip_of(ASF.replace("ltibia", "l" * 1100))
    with pytest.raises(LimitError, match="more than 2 bones"):
        clip_of(limits=Limits(joints=2))
    with pytest.raises(LimitError, match="too deep"):
        clip_of(limits=Limits(depth=2))
    with pytest.raises(LimitError, match="frames"):
        frames(clip_of(limits=Limits(frames=1)))


def test_several_roots_are_refused() -> None:
    from dataclasses import replace

    clip = clip_of()
    joints = [
        replace(joint, parent=-1 if joint.name == "lfemur" else joint.parent) for joint in clip.head.skeleton.joints
    ]
    several = clip.with_head(replace(clip.head, skeleton=replace(clip.head.skeleton, joints=tuple(joints))))
    with pytest.raises(ConversionError, match="2 roots"):
        written(FORMATS[NAME], several)


def test_names_that_asf_cannot_hold_are_changed_with_a_notice() -> None:
    from dataclasses import replace

    clip = clip_of()
    names = ["root", "Left Hip", "left_hip", "root"]
    joints = tuple(replace(j, source_name=n) for j, n in zip(clip.head.skeleton.joints, names, strict=True))
    odd = clip.with_head(replace(clip.head, skeleton=replace(clip.head.skeleton, joints=joints)))
    again = read(FORMATS[NAME], written(FORMATS[NAME], odd))
    assert [joint.source_name for joint in again.head.skeleton.joints] == ["root", "Left_Hip", "left_hip_2", "_root"]
    assert any("names that ASF cannot hold" in notice.what for notice in odd.notices)
    assert len(frames(again)) == 2


@pytest.mark.parametrize(
    ("asf", "flag", "said"),
    [
        (LEG, b":DEGREES\n", None),
        (LEG, b"", "its angles count as degrees, the unit of the ASF"),
        (LEG.replace(b"angle deg", b"angle rad"), b"", "its angles count as radians, the unit of the ASF"),
        (LEG.replace(b"  angle deg\n", b""), b"", "its angles count as degrees, since the ASF states no unit either"),
    ],
)
def test_the_unit_of_angles_is_stated_or_said_to_be_a_guess(asf: bytes, flag: bytes, said: str | None) -> None:
    clip = read(FORMATS["asf-amc"], {"asf": asf, "amc": amc().replace(b":DEGREES\n", flag)})
    found = [notice.what for notice in clip.notices if "neither :DEGREES" in notice.what]
    assert found == ([f"the AMC says neither :DEGREES nor :RADIANS; {said}"] if said else [])
    own = any("the ASF states no unit of angle" in notice.what for notice in clip.notices)
    assert own == (b"angle" not in asf)
