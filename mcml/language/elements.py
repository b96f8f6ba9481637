"""Elements of the head of a document (everything except its frames), and the head of a clip.

`from_head` and `to_head` are inverse: a clip's head as elements of `mcml.dtd`, and back.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mcml.errors import DocumentError, Place
from mcml.language.bones import read_skeleton, write_skeleton
from mcml.language.element import Element, addresses, elements, leaf
from mcml.language.lexical import WHITE_SPACE, escape, is_decimal, join_list, split_list, unescape
from mcml.language.vocabulary import (
    COMMENT,
    DATAFRAME_RATE,
    DESCRIPTION,
    HEADER,
    HEADER_LEAVES,
    HEADER_LEAVES_AFTER_UNITS,
    HEADER_LEAVES_BEFORE_UNITS,
    LANGUAGE_VERSION,
    MCML,
    MOTION,
    NUM_FRAMES,
    NUM_SEGMENTS,
    PROPERTY,
    SECTION,
    SOURCE,
    UNIT_ATTRIBUTES,
    UNITS,
)
from mcml.motion.clip import ClipHead, SourcePart
from mcml.motion.skeleton import Skeleton

__all__ = ["Element", "addresses", "check_counts", "from_head", "header_of", "joint_names", "leaf", "refresh_counts"]
__all__ += ["mcml_element", "to_head", "write_header"]

DEFAULT_STYLE = "shortest"


def from_head(head: ClipHead) -> Element:
    """The `mcml` element of a clip with header, root and skeleton, without motion.

    `to_head(from_head(head), head.frame_time) == head`; frame_time is in the motion (Table 4, 3). Parts of
    `head.sources` need different `part` names, otherwise their comments cannot be distinguished.
    """
    return mcml_element(write_header(head), write_skeleton(head.skeleton))


def mcml_attributes(version: str) -> dict[str, str]:
    """The attributes of an `mcml` element. version: "" where a document states none."""
    return {"version": version} if version else {}


def mcml_element(header: Element, skeleton: Iterable[Element]) -> Element:
    """An `mcml` element without motion. skeleton: `root`, if there is one, and `skeleton`."""
    return Element(MCML, {"version": LANGUAGE_VERSION}, "", [header, *skeleton])


def to_head(document: Element, frame_time: str | None = None, skeleton: Skeleton | None = None) -> ClipHead:
    """Read a clip's head from the header, root and skeleton of a document.

    document: an `mcml` element that is valid (`mcml.language.dtd`), with or without its motion.
    frame_time: text of motion/frametime; taken from the motion if the element has one. skeleton: the skeleton, if it is
    already known. Parts that a hand-written document leaves out get the defaults in docs/mcml.md. Raises DocumentError
    with the address of the invalid element.
    """
    header = header_of(document)
    fields = _read_fields(header)
    motion = document.first(MOTION)
    if motion is not None and frame_time is None:
        frame_time = motion.leaf("frametime")
    if frame_time is not None:
        frame_time = frame_time.strip(WHITE_SPACE)
        _need_decimal(frame_time, "/mcml/motion/frametime")
    file_format = format_of(header)
    return ClipHead(
        format=file_format,
        skeleton=read_skeleton(document, file_format) if skeleton is None else skeleton,
        fields=fields,
        frame_time=frame_time,
        number_style=header.attributes.get("number_style", DEFAULT_STYLE),
        sources=_read_sources(header),
        description=unescape(header.leaf(DESCRIPTION) or ""),
        properties=tuple(
            (
                unescape(item.attributes["name"]),
                unescape(item.attributes["value"]),
                unescape(item.attributes.get("unit", "")),
            )
            for item in header.all(PROPERTY)
        ),
    )


def header_of(document: Element) -> Element:
    """The `header` of an `mcml` element. Raises DocumentError where it has none."""
    header = document.first(HEADER)
    if document.tag != MCML or header is None:
        raise DocumentError(
            "the document has no header", at=Place(element=f"/{document.tag}"), remedy="Begin mcml with a header."
        )
    return header


def joint_names(document: Element) -> tuple[str, ...]:
    """The name of every joint as frames write it in frame_bone/@name, joints in their order (root first)."""
    return tuple(escape(joint.name) for joint in read_skeleton(document, "").joints)


def check_counts(document: Element, frames: int) -> None:
    """Raises DocumentError where num_frames or num_segments of the header disagree with the motion and skeleton.

    frames: how many frames the motion has.
    """
    header = header_of(document)
    for tag, actual, what in _counts(document, frames):
        stated = header.leaf(tag)
        if stated is not None and (not stated.isascii() or not stated.isdigit() or int(stated) != actual):
            raise DocumentError(
                f"{tag} says {stated!r}, the document has {actual} {what}",
                at=Place(element=f"/mcml/header/{tag}"),
                remedy=f"Write {actual}, or leave {tag} out.",
            )


def refresh_counts(document: Element, frames: int) -> Element:
    """The document with num_frames and num_segments, where the header states them, made true."""
    header = header_of(document)
    actual = {tag: str(count) for tag, count, _ in _counts(document, frames)}
    fresh = Element(HEADER, header.attributes, header.text)
    fresh.children = [leaf(child.tag, actual[child.tag]) if child.tag in actual else child for child in header.children]
    children = [fresh if child is header else child for child in document.children]
    return Element(document.tag, document.attributes, document.text, children)


def _counts(document: Element, frames: int) -> Sequence[tuple[str, int, str]]:
    joints = sum(element.tag in ("root", "bone") for element in elements(document))
    return ((NUM_SEGMENTS, joints, "joints (the root counts)"), (NUM_FRAMES, frames, "frames"))


def write_header(head: ClipHead) -> Element:
    """The `header` of a clip."""
    header = Element(HEADER, {"format": escape(head.format)})
    if head.number_style != DEFAULT_STYLE:
        header.attributes["number_style"] = head.number_style
    add = header.children.append
    for tag in HEADER_LEAVES_BEFORE_UNITS:
        if tag in head.fields:
            add(leaf(tag, escape(head.fields[tag])))
    units = {name: escape(head.fields[f"units_{name}"]) for name in UNIT_ATTRIBUTES if f"units_{name}" in head.fields}
    if units:
        add(Element(UNITS, units))
    for tag in HEADER_LEAVES_AFTER_UNITS:
        if tag in head.fields:
            add(leaf(tag, escape(head.fields[tag])))
    if head.description:
        add(leaf(DESCRIPTION, escape(head.description)))
    for name, value, unit in head.properties:
        attributes = {"name": escape(name), "value": escape(value)}
        add(Element(PROPERTY, attributes | ({"unit": escape(unit)} if unit else {})))
    for part in head.sources:
        add(_write_source(part))
    for part in head.sources:
        for keyword, text in part.sections:
            add(leaf(SECTION, escape(text), part=escape(part.part), name=escape(keyword)))
    for part in head.sources:
        for comment in part.comments:
            add(leaf(COMMENT, escape(comment), part=escape(part.part)))
    return header


def _write_source(part: SourcePart) -> Element:
    attributes = {"part": escape(part.part)}
    if part.name:
        attributes["name"] = escape(part.name)
    attributes["encoding"] = part.encoding
    if part.keywords:
        attributes["keywords"] = join_list(part.keywords)
    if part.flags:
        attributes["flags"] = join_list(part.flags)
    if part.missing:
        attributes["missing"] = escape(part.missing)
    return Element(SOURCE, attributes)


def _read_fields(header: Element) -> dict[str, str]:
    fields: dict[str, str] = {}
    for child in header.children:
        if child.tag in HEADER_LEAVES:
            fields[child.tag] = unescape(child.text.strip(WHITE_SPACE))
        elif child.tag == UNITS:
            fields.update({f"units_{name}": unescape(value) for name, value in child.attributes.items()})
    if DATAFRAME_RATE in fields:
        _need_decimal(fields[DATAFRAME_RATE], f"/mcml/header/{DATAFRAME_RATE}")
    return fields


def _read_sources(header: Element) -> tuple[SourcePart, ...]:
    stated = {unescape(source.attributes["part"]): source.attributes for source in header.all(SOURCE)}
    # A section or comment that names no part belongs to the first file of the source.
    first = next(iter(stated), "mcml")
    sections: dict[str, list[tuple[str, str]]] = {}
    comments: dict[str, list[str]] = {}
    for child in header.children:
        part = unescape(child.attributes.get("part", first))
        text = unescape(child.text.strip(WHITE_SPACE))
        if child.tag == SECTION:
            sections.setdefault(part, []).append((unescape(child.attributes["name"]), text))
        elif child.tag == COMMENT:
            comments.setdefault(part, []).append(text)
    return tuple(
        SourcePart(
            part=part,
            name=unescape(stated.get(part, {}).get("name", "")),
            encoding=stated.get(part, {}).get("encoding", "utf-8"),
            keywords=split_list(stated.get(part, {}).get("keywords", "")),
            flags=split_list(stated.get(part, {}).get("flags", "")),
            comments=tuple(comments.get(part, ())),
            sections=tuple(sections.get(part, ())),
            missing=unescape(stated.get(part, {}).get("missing", "")),
        )
        for part in dict.fromkeys([*stated, *sections, *comments])
    )


def format_of(header: Element) -> str:
    """The format that a header names, or that its file type is of."""
    return header.attributes.get("format") or _guess_format(_read_fields(header))


def _guess_format(fields: dict[str, str]) -> str:
    filetype = fields.get("filetype", "").lower()
    if filetype in ("htr", "bvh", "trc", "c3d"):
        return filetype
    return "asf-amc" if filetype in ("asf", "amc", "asf/amc", "asf-amc") else "mcml"


def _need_decimal(text: str, address: str) -> None:
    if not is_decimal(text):
        raise DocumentError(f"{text!r} is not a finite number", at=Place(element=address))
