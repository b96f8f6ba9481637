"""What is written is valid, reads back bit for bit, and has the promised layouts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from mcml.errors import DocumentError
from mcml.language import dtd
from mcml.language.content import declarations
from mcml.language.elements import from_head
from mcml.language.lexical import escape
from mcml.language.writer import Layout, write_document, write_frames
from mcml.motion.clip import ClipHead, FrameBlock
from mcml.motion.skeleton import CHANNELS
from tests.mcml.strategies import FINITE, blocks, documents, heads, small_document


@given(documents())
def test_what_is_written_is_valid(document: bytes) -> None:
    assert dtd.violations(document) == []


@given(blocks(3), st.sampled_from(Layout))
def test_frames_say_exactly_what_the_block_says(block: FrameBlock, layout: Layout) -> None:
    names = ("a", " <b> ", "c\n")
    xml = b"<motion>" + b"".join(write_frames(block, names, layout=layout)) + b"</motion>"
    frames = etree.fromstring(xml)
    assert len(frames) == len(block)
    for index, frame in enumerate(frames):
        assert frame.get("id") == str(block.ids[index])
        shape = block.shapes[0 if block.shape_of is None else int(block.shape_of[index])]
        bones = frame.findall("frame_bone")
        assert [bone.get("name") for bone in bones] == [escape(names[joint]) for joint, _ in shape]
        for bone, (joint, bits) in zip(bones, shape, strict=True):
            assert list(bone.attrib)[1:] == [name for place, name in enumerate(CHANNELS) if bits >> place & 1]
            for channel, text in list(bone.attrib.items())[1:]:
                value = block.values[index, block.columns.index((joint, CHANNELS.index(channel)))]
                assert np.float64(text).tobytes() == value.tobytes()
        labels = [name.text for name in frame.findall("motion_name")]
        assert labels == [escape(name) for name in (block.motion_names or [()] * len(block))[index]]


@given(blocks(2, most=6), st.integers(0, 6), st.integers(0, 6))
def test_a_range_is_a_part_of_the_whole(block: FrameBlock, first: int, last: int) -> None:
    names = ("a", "b")
    frames = [b"".join(write_frames(block, names, first=index, last=index + 1)) for index in range(len(block))]
    assert b"".join(write_frames(block, names, first=first, last=last)) == b"".join(frames[first:last])


@given(st.lists(FINITE, min_size=1, max_size=8))
def test_one_frame_bone(values: list[float]) -> None:
    bits = (1 << len(values)) - 1
    columns = tuple((0, channel) for channel in range(len(values)))
    block = FrameBlock(np.array([values]), columns, (((0, bits),),), np.array([1]))
    (node,) = etree.fromstring(b"".join(write_frames(block, ("hips & co",))))
    assert node.get("name") == "hips & co"
    assert [float(text) for text in list(node.attrib.values())[1:]] == values


@given(heads(), blocks(1))
def test_layouts_differ_in_white_space_only(head: ClipHead, block: FrameBlock) -> None:
    names = head.skeleton.names
    written = {
        layout: b"".join(write_document(from_head(head), len(block), None, [block], names, layout=layout))
        for layout in Layout
    }
    stripped = {etree.tostring(_stripped(text)) for text in written.values()}
    assert len(stripped) == 1
    compact = written[Layout.COMPACT].partition(b"<mcml")[2]
    assert etree.tostring(etree.fromstring(b"<mcml" + compact)) in stripped
    assert written[Layout.LINES].count(b"\n<frame ") == len(block)


def _stripped(text: bytes) -> etree._Element:
    root = etree.fromstring(text)
    for node in root.iter():
        if declarations()[str(node.tag)].kind == "elements":
            node.text = None
        node.tail = None
    return root


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_refused(value: float) -> None:
    block = FrameBlock(np.array([[value]]), ((0, 0),), (((0, 1),),), np.array([1]))
    with pytest.raises(DocumentError, match="not a finite number"):
        b"".join(write_frames(block, ("a",)))


def test_numbers_are_in_the_shortest_form() -> None:
    block = FrameBlock(np.array([[0.1, -0.0, 1e22]]), ((0, 0), (0, 1), (0, 2)), (((0, 7),),), np.array([1]))
    assert b"".join(write_frames(block, ("a",), layout=Layout.COMPACT)) == (
        b'<frame id="1"><frame_bone name="a" Tx="0.1" Ty="-0.0" Tz="1e+22"/></frame>'
    )


def test_pretty_documents_are_indented() -> None:
    lines = small_document(pretty=True).decode().splitlines()
    assert '      <frame_bone name="Root" Tx="0.0" Ty="0.25" Tz="0.5" Rx="0.75" Ry="1.0" Rz="1.25"/>' in lines
