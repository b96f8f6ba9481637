"""Generated heads, frames and documents for the tests of the language."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from hypothesis import strategies as st

from mcml.language.elements import from_head
from mcml.language.writer import Layout, write_document
from mcml.motion.clip import ClipHead, FrameBlock, SourcePart, full_shape
from mcml.motion.skeleton import CHANNELS, Convention, EndSite, Joint, Skeleton, unique_names

LEXEMES = st.sampled_from(["0", "-0", "1.0", "5.7300", "-160.5", ".5", "+1", "4.48953e-011", "-0.0", "1e3"])
TRIPLES = st.tuples(LEXEMES, LEXEMES, LEXEMES)
ORDERS = st.permutations("XYZ").map("".join)
HARD_TEXTS = st.one_of(
    st.text(max_size=12),
    st.sampled_from(
        [" a ", "\t", "a\rb", "a\nb", "\\u{41}", "\\u{", "F:\\VICON\\x", "\x00\x1f", "<&>\"'", "]]>", "한글"]
    ),
)
NAMES = st.one_of(
    st.sampled_from(["Hips", "left_up_arm", " a b ", "mixamorig:Hips", "x#2", "뼈"]), HARD_TEXTS.filter(bool)
)


@st.composite
def parents(draw: st.DrawFn, several_roots: bool, most: int = 9) -> list[int]:
    """Parents of a pre-order: each joint hangs from the joint before it or one of that joint's ancestors."""
    result: list[int] = []
    for index in range(draw(st.integers(1, most))):
        chain = [index - 1] if index else [-1]
        while chain[-1] >= 0:
            chain.append(result[chain[-1]])
        if index and not several_roots:
            chain.remove(-1)
        result.append(draw(st.sampled_from(chain)))
    return result


@st.composite
def end_sites(draw: st.DrawFn, children: int) -> tuple[EndSite, ...]:
    befores = sorted(draw(st.lists(st.integers(0, children), max_size=2)))
    return tuple(EndSite(draw(TRIPLES), draw(st.one_of(st.just(""), HARD_TEXTS)), before) for before in befores)


@st.composite
def skeletons(draw: st.DrawFn, convention: Convention) -> Skeleton:
    """A skeleton with everything that files of the convention can state, and some that state less."""
    tree = draw(parents(several_roots=convention is Convention.BASE or draw(st.booleans())))
    names = unique_names(draw(st.lists(NAMES, min_size=len(tree), max_size=len(tree))))
    optional = st.one_of
    joints = []
    for index, parent in enumerate(tree):
        channels = tuple(draw(st.lists(st.sampled_from((*CHANNELS[:7], "weight")), unique=True)))
        listed = "".join(channel[1] for channel in channels if channel[0] == "R")
        common = {
            "name": names[index],
            "parent": parent,
            "source_name": draw(st.one_of(st.just(names[index]), NAMES)),
            "convention": convention,
            "channels": channels,
            "translation": draw(st.sampled_from(["", "absolute", "relative"])),
            "mapped": draw(st.sampled_from([None, True, False])),
            "confidence": draw(st.sampled_from([None, "0.6"])),
            "role": draw(st.sampled_from([None, "jaw", "a & b"])),
            "offset": draw(optional(st.none(), TRIPLES)),
        }
        if convention is Convention.LISTED:
            joint = Joint(
                **common, rotation_order=listed, end_sites=draw(end_sites(sum(1 for other in tree if other == index)))
            )
        elif convention is Convention.FIXED:
            is_bone = parent >= 0
            joint = Joint(
                **common,
                rotation_order=draw(st.one_of(st.just(listed), ORDERS, st.just(""))),
                axis=draw(optional(st.none(), TRIPLES)),
                axis_order=draw(st.one_of(st.just(""), ORDERS)),
                direction=draw(optional(st.none(), TRIPLES)) if is_bone else None,
                length=draw(optional(st.none(), LEXEMES)) if is_bone else None,
                limits=tuple(draw(st.lists(st.sampled_from(["-160.0 20.0", "-inf inf", "0 0"]), max_size=3)))
                if is_bone
                else (),
                bodymass=draw(optional(st.none(), LEXEMES)),
                cofmass=draw(optional(st.none(), LEXEMES)),
                id=draw(st.one_of(st.none(), st.just("1"), HARD_TEXTS)),
            )
        else:
            order = draw(ORDERS)
            joint = Joint(**common, rotation_order=order, axis=draw(TRIPLES), axis_order=order, length=draw(LEXEMES))
        joints.append(joint)
    order = draw(st.permutations(range(len(joints))))
    declared = () if order == list(range(len(joints))) or convention is Convention.LISTED else tuple(order)
    return Skeleton(tuple(joints), declared)


@st.composite
def heads(draw: st.DrawFn) -> ClipHead:
    """Heads of BVH, ASF/AMC and HTR clips."""
    name, convention, parts = draw(
        st.sampled_from(
            [
                ("bvh", Convention.LISTED, ("bvh",)),
                ("asf-amc", Convention.FIXED, ("asf", "amc")),
                ("htr", Convention.BASE, ("htr",)),
            ]
        )
    )
    texts = (
        "filetype",
        "datatype",
        "filename",
        "version",
        "skeleton_name",
        "units_mass",
        "units_length",
        "units_angle",
    )
    fields = draw(st.dictionaries(st.sampled_from(texts), HARD_TEXTS))
    fields |= draw(st.dictionaries(st.sampled_from(["euler_rotation_order", "calibration_unit"]), HARD_TEXTS))
    fields |= draw(st.dictionaries(st.sampled_from(["dataframe_rate"]), LEXEMES))
    return ClipHead(
        format=name,
        skeleton=draw(skeletons(convention)),
        fields=fields,
        frame_time=draw(st.one_of(st.none(), LEXEMES)),
        number_style=draw(st.sampled_from(["shortest", "fixed:6", "general:9"])),
        sources=tuple(draw(source_parts(part)) for part in parts) if draw(st.booleans()) else (),
        description=draw(st.one_of(st.just(""), HARD_TEXTS)),
        properties=tuple(draw(st.lists(st.tuples(HARD_TEXTS, HARD_TEXTS, st.sampled_from(["", "year"])), max_size=2))),
    )


@st.composite
def source_parts(draw: st.DrawFn, part: str) -> SourcePart:
    return SourcePart(
        part=part,
        name=draw(HARD_TEXTS),
        encoding=draw(st.sampled_from(["utf-8", "cp949"])),
        keywords=tuple(draw(st.lists(HARD_TEXTS, max_size=2))),
        flags=tuple(draw(st.lists(st.sampled_from([":DEGREES", ":FULLY-SPECIFIED  x"]), max_size=2))),
        comments=tuple(draw(st.lists(HARD_TEXTS, max_size=2))),
        sections=tuple(draw(st.lists(st.tuples(HARD_TEXTS, HARD_TEXTS), max_size=2))),
        missing=draw(st.sampled_from(["", "9999999"])),
    )


FINITE = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False), st.sampled_from([0.0, -0.0, 1.0, 1e300, 5e-324, -4.48953e-11])
)


@st.composite
def blocks(draw: st.DrawFn, joints: int, most: int = 4) -> FrameBlock:
    """Frames of one or several shapes, with and without motion names, ids of any kind."""
    frames = draw(st.integers(0, most))
    shape = st.lists(st.tuples(st.integers(0, joints - 1), st.integers(0, 255)), unique_by=lambda bone: bone[0])
    shapes = tuple(draw(st.lists(shape.map(tuple), min_size=1, max_size=3, unique=True)))
    shape_of = [draw(st.integers(0, len(shapes) - 1)) for _ in range(frames)]
    used = list(dict.fromkeys(shape_of)) or [0]
    shapes, shape_of = tuple(shapes[index] for index in used), [used.index(index) for index in shape_of]
    bits = [(joint, channel) for own in shapes for joint, have in own for channel in range(8) if have >> channel & 1]
    columns = tuple(dict.fromkeys(bits))
    values = np.full((frames, len(columns)), np.nan)
    for frame, index in enumerate(shape_of):
        for joint, have in shapes[index]:
            for channel in range(8):
                if have >> channel & 1:
                    values[frame, columns.index((joint, channel))] = draw(FINITE)
    named = draw(st.booleans())
    names = [tuple(draw(st.lists(HARD_TEXTS.filter(str.strip), max_size=2))) for _ in range(frames)] if named else None
    plain = draw(st.booleans())
    ids = (
        np.arange(1, frames + 1)
        if plain
        else [draw(st.sampled_from(["1", "01", "a<b", '"', "7 8"])) for _ in range(frames)]
    )
    return FrameBlock(
        values,
        columns,
        shapes,
        ids,
        np.array(shape_of, dtype=np.intp) if len(shapes) > 1 else None,
        names,
    )


@st.composite
def documents(draw: st.DrawFn) -> bytes:
    """A valid document as XML, in any layout."""
    head = draw(heads())
    block = draw(blocks(len(head.skeleton)))
    layout = draw(st.sampled_from(Layout))
    return b"".join(
        write_document(from_head(head), len(block), head.frame_time, [block], head.skeleton.names, layout=layout)
    )


def small_document(frames: int = 2, pretty: bool = True) -> bytes:
    """A valid document with every element of the language."""
    names = ("Root", "left_up_leg", "left_low_leg")
    joints = (
        Joint("Root", -1, "root", Convention.FIXED, ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz"), "XYZ", ("0", "0", "0"),
              axis=("0", "0", "0"), axis_order="XYZ", end_sites=(EndSite(("0", "1", "0")),)),
        Joint(names[1], 0, "lfemur", Convention.FIXED, ("Rx", "Ry", "Rz"), "XYZ", ("1", "2", "3"),
              ("0", "1", "0"), "6.8", ("0", "0", "20"), "XYZ",
              limits=("-160 20", "-70 70", "-60 70"), bodymass="1", cofmass="2", id="1"),
        Joint(names[2], 1, "ltibia", Convention.LISTED, ("Rx",), "X", end_sites=(EndSite(("0", "1", "0"), "tip"),)),
    )  # fmt: skip
    fields = dict.fromkeys(
        ("filetype", "datatype", "filename", "version", "skeleton_name", "units_length", "euler_rotation_order"), "x"
    ) | {"num_frames": str(frames), "num_segments": "3", "dataframe_rate": "30", "scale_factor": "1"}
    fields |= dict.fromkeys(("calibration_unit", "global_axis_of_gravity", "bone_length_axis"), "y")
    head = ClipHead(
        "asf-amc",
        Skeleton(joints),
        fields,
        "0.0333",
        sources=(SourcePart("asf", "a.asf", comments=("# hi",), sections=((":skin", "x"),)),),
        description="a walk",
        properties=(("age", "23", "year"),),
    )
    columns = head.skeleton.columns()
    values = np.arange(frames * len(columns), dtype=np.float64).reshape(frames, len(columns)) / 4
    block = FrameBlock(
        values, columns, (full_shape(columns),), np.arange(1, frames + 1), motion_names=[("walk", "bar-1")] * frames
    )
    return b"".join(write_document(from_head(head), frames, "0.0333", [block], head.skeleton.names, pretty=pretty))


def stream(document: bytes) -> BytesIO:
    return BytesIO(document)
