"""Clips as ASF and AMC text."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcml.errors import ConversionError, Notice
from mcml.formats.target_names import legal_names
from mcml.formats.text.lines import encoded
from mcml.formats.text.number_text import rows_of_text
from mcml.motion.clip import ClipStream, FrameBlock, Shape, SourcePart
from mcml.motion.skeleton import CHANNEL_INDEX, Joint, Skeleton

_ILLEGAL = frozenset(" \t\v\f\r\n\0#(),")


def names_of(skeleton: Skeleton, notices: list[Notice]) -> list[str]:
    """The name of each joint as ASF and AMC write it; the root is always `root`."""
    reserved = {"root", "begin", "end"}
    return legal_names(skeleton, _ILLEGAL, ":", reserved, notices, "ASF", fold_case=True, root="root")


def write_asf(clip: ClipStream) -> Iterator[bytes]:
    """The skeleton file. Raises ConversionError unless there is exactly one root."""
    head = clip.head
    skeleton = head.skeleton
    if len(skeleton.roots) != 1:
        raise ConversionError(
            f"the skeleton has {len(skeleton.roots)} roots, ASF has one",
            remedy="Export one of them, or use BVH or HTR.",
        )
    part = next((source for source in head.sources if source.part == "asf"), SourcePart("asf"))
    names = names_of(skeleton, clip.notices)
    written = {
        ":version": [f":version {head.fields.get('version', '1.10')}"],
        ":name": [f":name {head.fields.get('skeleton_name', 'skeleton')}"],
        ":units": [":units", *_units(head.fields)],
        ":root": [":root", *_root(skeleton.joints[0])],
        ":bonedata": [":bonedata", *_bones(skeleton, names)],
        ":hierarchy": [":hierarchy", "  begin", *_hierarchy(skeleton, names), "  end"],
    }
    order = [keyword.lower() for keyword in part.keywords] or list(written)
    order += [keyword for keyword in (":root", ":bonedata", ":hierarchy") if keyword not in order]
    lines = list(part.comments)
    left = list(part.sections)
    for keyword in order:
        if keyword in written:
            lines += written[keyword]
        else:
            found = next((item for item in left if item[0].split()[0].lower() == keyword), None)
            if found is not None:
                left.remove(found)
                lines += [found[0], *([found[1]] if found[1] else [])]
    for title, text in left:
        lines += [title, *([text] if text else [])]
    yield encoded("\n".join(lines) + "\n", part.encoding, clip.notices)


def _units(fields: dict[str, str]) -> list[str]:
    names = ("mass", "length", "angle")
    return [f"  {name} {fields[f'units_{name}']}" for name in names if f"units_{name}" in fields]


def _dof(joint: Joint) -> list[str]:
    return ["l" if channel == "SF" else channel.lower() for channel in joint.channels]


def _root(root: Joint) -> list[str]:
    lines = ["  order " + " ".join(channel.upper() for channel in _dof(root))]
    if root.axis_order:
        lines.append(f"  axis {root.axis_order}")
    if root.offset is not None:
        lines.append("  position " + " ".join(root.offset))
    if root.axis is not None:
        lines.append("  orientation " + " ".join(root.axis))
    return lines


def _bones(skeleton: Skeleton, names: list[str]) -> Iterator[str]:
    for index in skeleton.in_declared_order():
        joint = skeleton.joints[index]
        if joint.parent < 0:
            continue
        yield "  begin"
        if joint.id is not None:
            yield f"    id {joint.id}"
        yield f"    name {names[index]}"
        if joint.direction is not None:
            yield "    direction " + " ".join(joint.direction)
        yield f"    length {joint.length or '0'}"
        if joint.axis is not None:
            yield f"    axis {' '.join(joint.axis)} {joint.axis_order}".rstrip()
        if joint.channels:
            yield "    dof " + " ".join(_dof(joint))
        for place, limits in enumerate(joint.limits):
            yield ("    limits " if not place else "           ") + f"({limits})"
        if joint.bodymass is not None:
            yield f"    bodymass {joint.bodymass}"
        if joint.cofmass is not None:
            yield f"    cofmass {joint.cofmass}"
        yield "  end"


def _hierarchy(skeleton: Skeleton, names: list[str]) -> Iterator[str]:
    children: list[list[str]] = [[] for _ in skeleton.joints]
    for name, joint in zip(names, skeleton.joints, strict=True):
        if joint.parent >= 0:
            children[joint.parent].append(name)
    for name, own in zip(names, children, strict=True):
        if own:
            yield f"    {name} {' '.join(own)}"


def write_amc(clip: ClipStream) -> Iterator[bytes]:
    """The motion file: frames with their original bones, order and ids. Raises ConversionError without frames."""
    head = clip.head
    if clip.frames == 0:
        raise ConversionError("AMC cannot hold a motion without frames", remedy="Export the ASF alone.")
    default = SourcePart("amc", flags=(":FULLY-SPECIFIED", ":DEGREES"))
    part = next((source for source in head.sources if source.part == "amc"), default)
    names = names_of(head.skeleton, clip.notices)
    head_text = "".join(f"{line}\n" for line in (*part.comments, *part.flags))
    yield encoded(head_text, part.encoding, clip.notices)
    codec = "utf-8" if part.encoding == "utf-8-sig" else part.encoding
    shown = [encoded(name, codec, clip.notices) for name in names]
    style = head.number_style if head.format == "asf-amc" else "shortest"
    for block in clip.blocks():
        yield from _frames(head.skeleton, block, shown, style)


def _frames(skeleton: Skeleton, block: FrameBlock, names: list[bytes], style: str) -> Iterator[bytes]:
    place = {column: index for index, column in enumerate(block.columns)}
    ids = [str(item).encode() for item in block.ids]
    shape_of = np.zeros(len(block), dtype=np.intp) if block.shape_of is None else block.shape_of
    start = 0
    while start < len(block):
        changes = np.flatnonzero(shape_of[start:] != shape_of[start])
        end = start + int(changes[0]) if len(changes) else len(block)
        bones = _bones_of(skeleton, block.shapes[int(shape_of[start])])
        texts = [ids[start:end]]
        for joint, channels in bones:
            values = block.values[start:end, [place[joint, channel] for channel in channels]]
            name = names[joint]
            texts.append([name + b" " + row if row else name for row in rows_of_text(values, style)])
        yield b"\n".join([line for frame in zip(*texts, strict=True) for line in frame]) + b"\n"
        start = end


def _bones_of(skeleton: Skeleton, shape: Shape) -> list[tuple[int, list[int]]]:
    """(joint, channels in dof order) of the bones of a frame that has all values of each."""
    bones = []
    for joint, bits in shape:
        wanted = [CHANNEL_INDEX[channel] for channel in skeleton.joints[joint].channels]
        if bits == sum(1 << channel for channel in wanted):
            bones.append((joint, wanted))
    return bones
