"""Valid documents with changes that break them, or not; and slow, obvious judges of them."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator
from functools import cache
from io import BytesIO
from random import Random
from typing import Any

from lxml import etree

from mcml.errors import DocumentError
from mcml.language import dtd
from mcml.language.element import Element
from mcml.language.lexical import is_decimal, unescape
from mcml.language.reader import read_document
from tests.mcml.samples import captures, generated, hand_written


@cache
def pool() -> tuple[bytes, ...]:
    """Valid documents to break."""
    return (*hand_written(), *captures(), *generated(60))


def rules_hold(document: bytes) -> bool:
    """The rules beyond the DTD, the slow and obvious way."""
    root: Any = etree.fromstring(document)
    text = lambda node: (node.text or "").strip(" \t\r\n")  # noqa: E731
    motion = root.find("motion")
    frames = motion.findall("frame")
    if not text(motion[0]).isdigit() or int(text(motion[0])) != len(frames):
        return False
    joints = root.findall("root") + list(root.find("skeleton").iter("bone"))
    counts = {"num_frames": len(frames), "num_segments": len(joints)}
    if any(text(node) != str(counts[node.tag]) for node in root.iter(*counts)):
        return False
    names = [unescape(j.get("name", "Root") if j.tag == "root" else text(j.find("name"))) for j in joints]
    if len(set(names)) != len(names) or any(not text(j.find("name")) for j in joints if j.tag == "bone"):
        return False
    numbers = [(node, 3) for tag in ("direction", "position") for node in root.iter(tag)]
    numbers += [(node, 1) for tag in ("length", "bodymass", "cofmass", "frametime") for node in root.iter(tag)]
    numbers += [(node, 1) for node in root.iter("dataframe_rate")]
    if any(len(text(node).split()) != n or not all(map(is_decimal, text(node).split())) for node, n in numbers):
        return False
    if not all(_is_axis(text(node)) for node in root.iter("axis")):
        return False
    for frame in frames:
        bones = [bone.get("name") for bone in frame.findall("frame_bone")]
        if len(set(bones)) != len(bones) or not {unescape(name) for name in bones} <= set(names):
            return False
        if any(not text(name) for name in frame.findall("motion_name")):
            return False
        for bone in frame.findall("frame_bone"):
            if any(
                not is_decimal(value) or not math.isfinite(float(value)) for value in list(bone.attrib.values())[1:]
            ):
                return False
    return True


def _is_axis(text: str) -> bool:
    """Three angles, an order, or both, or neither."""
    words = text.split()
    angles = len(words) >= 3 and all(map(is_decimal, words[:3]))
    return len(words) <= (4 if angles else 1) and not (len(words) == 1 and is_decimal(words[0]))


TAGS = ("header", "bone", "name", "frame", "frame_bone", "motion_name", "frames", "axis", "root", "nothing", "end_site")


def mutate(random: Random, document: bytes) -> bytes:
    """The document with one element or attribute changed somehow."""
    root: Any = etree.fromstring(document)
    node = random.choice(list(root.iter(etree.Element)))
    parent = node.getparent()
    kind = random.choice(["remove", "rename", "double", "swap", "text", "tail", "drop", "add", "comment"])
    if kind == "remove" and parent is not None:
        parent.remove(node)
    elif kind == "rename" and node.tag not in OTHER_RULES:
        node.tag = random.choice(TAGS)
    elif kind == "double" and parent is not None:
        parent.insert(parent.index(node), copy.deepcopy(node))
    elif kind == "swap" and node.getnext() is not None:
        parent.insert(parent.index(node), node.getnext())
    elif kind == "text" and node.tag not in OTHER_RULES:
        node.text = random.choice(["x", " ", "1"])
    elif kind == "tail" and parent is not None:
        node.tail = random.choice(["x", " ", "1"])
    elif kind == "drop" and node.attrib:
        del node.attrib[random.choice(sorted(node.attrib))]
    elif kind == "add":
        name = random.choice(["id", "name", "Tx", "mapped", "convention", "version", "unknown"])
        node.set(name, random.choice(["1", "true", "listed", "x"]))
    elif kind == "comment":
        node.append(etree.Comment("c"))
    return etree.tostring(root)


OTHER_RULES = ("axis", "order", "dof", "num_frames", "num_segments")
"""Elements whose text has rules that `rules_hold` does not know."""


def broken_documents(seed: int, count: int) -> Iterator[bytes]:
    """Documents with none to three changes."""
    random = Random(seed)
    whole = pool()
    for _ in range(count):
        document = random.choice(whole)
        for _ in range(random.randrange(4)):
            document = mutate(random, document)
        yield document


def leading_children(document: bytes) -> int:
    """How many children of motion stand before its frames."""
    motion: Any = etree.fromstring(document).find("motion")
    return len(motion) - len(motion.findall("frame"))


def with_changed_frames(random: Random, document: bytes) -> bytes:
    """The document with up to two of its frames changed somehow."""
    root: Any = etree.fromstring(document)
    leading = leading_children(document)
    for _ in range(random.randrange(3)):
        frame = random.choice(list(root.find("motion"))[leading:])
        changed = etree.fromstring(mutate(random, etree.tostring(frame, with_tail=False)))
        if not list(changed.iter(etree.Comment)):
            frame.getparent().replace(frame, changed)
    return etree.tostring(root)


def with_changed_head(random: Random, document: bytes) -> bytes:
    """The document with a change in its header, root or skeleton, or none."""
    root: Any = etree.fromstring(document)
    if random.random() < 0.7:
        part = random.choice([child for child in root if child.tag != "motion"])
        changed = etree.fromstring(mutate(random, etree.tostring(part, with_tail=False)))
        if not list(changed.iter(etree.Comment)):
            root.replace(part, changed)
    return etree.tostring(root)


def shapes_verdict(document: bytes, leading: int) -> bool:
    """Whether the head and one frame of every shape are valid. leading: children of motion before its frames."""
    root: Any = etree.fromstring(document)
    return _raises_nothing(
        dtd.validate_frames, _element(root), [_element(node) for node in root.find("motion")][leading:]
    )


def clip_verdict(document: bytes, valid: bytes) -> bool:
    """Whether the head of a document is valid with the shapes of the frames of a valid one, as an import asks it."""
    clip = read_document(BytesIO(valid)).clip
    shapes = []
    for block in clip.blocks():
        for index in range(len(block)):
            shape = block.shapes[0 if block.shape_of is None else int(block.shape_of[index])]
            shapes.append((shape, 0 if block.motion_names is None else len(block.motion_names[index])))
    return _raises_nothing(
        dtd.validate_by_shapes, _element(etree.fromstring(document)), shapes, clip.head.skeleton.names
    )


def _raises_nothing(validate: Callable[..., None], *arguments: Any) -> bool:
    try:
        validate(*arguments)
    except DocumentError:
        return False
    return True


def _element(node: Any) -> Element:
    children = [_element(child) for child in node if isinstance(child.tag, str)]
    text = (node.text or "") + "".join(child.tail or "" for child in node)
    return Element(str(node.tag), dict(node.attrib), text if text.strip() or not children else "", children)
