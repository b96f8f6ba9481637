"""Joints of a skeleton as `root` and `bone` elements, and back (Table 3 of the paper).

With `root` that is joint 0 and the top bones are its children; without, every top bone is a root. Joints are
numbered root first, then bones in document order.
"""

from __future__ import annotations

from dataclasses import replace

from mcml.errors import DocumentError, Place
from mcml.language.addresses import address_attribute
from mcml.language.element import Element, addresses, leaf
from mcml.language.lexical import WHITE_SPACE, escape, is_decimal, split_list, unescape
from mcml.language.vocabulary import (
    AXIS,
    BODYMASS,
    BONE,
    CHANNEL_OF,
    COFMASS,
    DEFAULT_ROOT_NAME,
    DIRECTION,
    DOF,
    END_SITE,
    LENGTH,
    LIMITS,
    NAME,
    ORDER,
    POSITION,
    ROOT,
    SKELETON,
)
from mcml.motion.skeleton import CHANNELS, ROTATIONS, Convention, EndSite, Joint, Skeleton, Triple

MAX_DEPTH = 256
"""Bones in bones that a skeleton may have; no body comes near it."""

_CONVENTION_OF_FORMAT = {
    "bvh": Convention.LISTED,
    "asf-amc": Convention.FIXED,
    "htr": Convention.BASE,
    "c3d": Convention.MARKER,
    "trc": Convention.MARKER,
}
_CHANNELS_OF_BASE = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")


def write_skeleton(skeleton: Skeleton) -> list[Element]:
    """The `root` element, if the skeleton has one that the paper's `root` can hold, and the `skeleton` element.

    Raises DocumentError where bones are nested deeper than MAX_DEPTH.
    """
    root = skeleton.roots[0] if len(skeleton.roots) == 1 else -1
    if root >= 0 and not _fits_root(skeleton.joints[root]):
        root = -1
    elements = [
        _write_root(joint) if index == root else _write_bone(joint) for index, joint in enumerate(skeleton.joints)
    ]
    for rank, index in enumerate(skeleton.declared, start=1):
        elements[index].attributes["declared"] = str(rank)
    children: list[list[int]] = [[] for _ in elements]
    depth: list[int] = []
    for index, joint in enumerate(skeleton.joints):
        depth.append(depth[joint.parent] + 1 if joint.parent >= 0 else 0)
        if depth[index] > MAX_DEPTH:
            raise DocumentError(f"bone {joint.name!r} is nested deeper than {MAX_DEPTH} bones")
        if joint.parent >= 0:
            children[joint.parent].append(index)
    for index, element in enumerate(elements):
        if index != root:
            _fill_bone(element, skeleton.joints[index].end_sites, [elements[child] for child in children[index]])
    if root < 0:
        return [Element(SKELETON, children=[elements[index] for index in skeleton.roots])]
    return [elements[root], Element(SKELETON, children=[elements[child] for child in children[root]])]


def read_skeleton(document: Element, file_format: str) -> Skeleton:
    """The skeleton that the `root` and `skeleton` elements of a valid document describe.

    file_format: the source format, which decides the convention of joints that state none.
    Raises DocumentError with the element's address: names used twice, invalid numbers, unknown channels.
    """
    fallback = _CONVENTION_OF_FORMAT.get(file_format) or _guess_convention(document)
    joints: list[Joint] = []
    parent_of: dict[int, int] = {}
    ranks: dict[int, int] = {}
    has_root = document.first(ROOT) is not None
    for address, element in addresses(document):
        if element.tag not in (ROOT, BONE, SKELETON):
            continue
        if element.tag == SKELETON:
            parent_of.update({id(bone): 0 if has_root else -1 for bone in element.children})
            continue
        parent = parent_of.get(id(element), -1)
        inherited = joints[parent].convention if parent >= 0 else fallback
        convention = Convention(element.attributes.get("convention", inherited))
        read = _read_root if element.tag == ROOT else _read_bone
        index = len(joints)
        joints.append(read(element, address, parent, convention))
        parent_of.update({id(bone): index for bone in element.children})
        if "declared" in element.attributes:
            ranks[index] = _integer(element.attributes["declared"], address_attribute(address, "declared"))
    _refuse_equal_names(joints)
    return Skeleton(tuple(joints), _declared(ranks, len(joints)))


def _fits_root(joint: Joint) -> bool:
    """Whether the paper's `root`, which has no name, length or limits, can hold the joint."""
    absent = (joint.direction, joint.length, joint.bodymass, joint.cofmass, joint.id)
    stated = bool(joint.limits) or any(value is not None for value in absent)
    return joint.convention in (Convention.LISTED, Convention.FIXED) and not stated


def _write_root(joint: Joint) -> Element:
    root = Element(ROOT)
    if joint.channels:
        root.attributes["order"] = " ".join(joint.channels)
    if joint.axis_order:
        root.attributes["axis"] = escape(joint.axis_order)
    if joint.offset is not None:
        root.attributes["position"] = " ".join(joint.offset)
    if joint.axis is not None:
        root.attributes["orientation"] = " ".join(joint.axis)
    root.attributes["name"] = escape(joint.name)
    root.attributes |= _shared_attributes(joint, "order")
    for site in joint.end_sites:
        element = _write_end_site(site)
        if site.before:
            element.attributes["before"] = str(site.before)
        root.children.append(element)
    return root


def _write_bone(joint: Joint) -> Element:
    channels_tag = DOF if joint.convention is Convention.FIXED else ORDER
    bone = Element(BONE)
    if joint.id is not None:
        bone.attributes["id"] = escape(joint.id)
    bone.attributes |= _shared_attributes(joint, channels_tag)
    axis = " ".join((*(joint.axis or ()), *((joint.axis_order,) if joint.axis_order else ())))
    channels = " ".join(joint.channels)
    if channels_tag == DOF:
        channels = " ".join("l" if channel == "SF" else channel.lower() for channel in joint.channels)
    optional = (
        (DIRECTION, None if joint.direction is None else " ".join(joint.direction)),
        (LENGTH, joint.length),
        (POSITION, None if joint.offset is None else " ".join(joint.offset)),
        (AXIS, axis or None),
        # A joint of HTR without this element has all six channels, so the absence of channels must be stated.
        (channels_tag, channels if channels or joint.convention is Convention.BASE else None),
    )
    bone.children = [leaf(NAME, escape(joint.name))]
    bone.children += [leaf(tag, escape(text)) for tag, text in optional if text is not None]
    bone.children += [leaf(LIMITS, escape(text)) for text in joint.limits]
    masses = ((BODYMASS, joint.bodymass), (COFMASS, joint.cofmass))
    bone.children += [leaf(tag, escape(text)) for tag, text in masses if text is not None]
    return bone


def _shared_attributes(joint: Joint, channels_tag: str) -> dict[str, str]:
    attributes = {}
    if joint.source_name != joint.name:
        attributes["source_name"] = escape(joint.source_name)
    if joint.mapped is not None:
        attributes["mapped"] = "true" if joint.mapped else "false"
    if joint.confidence is not None:
        attributes["confidence"] = escape(joint.confidence)
    if joint.role is not None:
        attributes["role"] = escape(joint.role)
    attributes["convention"] = joint.convention.value
    if joint.translation:
        attributes["translation"] = joint.translation
    if joint.rotation_order or _default_order(joint.convention, joint.channels, joint.axis_order):
        attributes["rotation_order"] = escape(joint.rotation_order)
    return attributes


def _write_end_site(site: EndSite) -> Element:
    attributes = {"position": " ".join(site.offset)}
    return Element(END_SITE, attributes | ({"name": escape(site.name)} if site.name else {}))


def _fill_bone(bone: Element, sites: tuple[EndSite, ...], children: list[Element]) -> None:
    """Child bones, with the end sites between them where the source has them."""
    for place, child in enumerate(children):
        bone.children += [_write_end_site(site) for site in sites if site.before == place]
        bone.children.append(child)
    bone.children += [_write_end_site(site) for site in sites if site.before >= len(children)]


def _read_root(element: Element, address: str, parent: int, convention: Convention) -> Joint:
    get = element.attributes.get
    name = unescape(get("name", DEFAULT_ROOT_NAME))
    channels = _channels(get("order", ""), address_attribute(address, "order"))
    sites = []
    for place, site in enumerate(element.children, start=1):
        where = f"{address}/end_site[{place}]"
        sites.append(_read_end_site(site, where, _integer(site.attributes.get("before", "0"), f"{where}/@before")))
    return replace(
        _read_shared(element, name, parent, convention, channels, unescape(get("axis", ""))),
        offset=_triple(get("position"), address_attribute(address, "position")),
        axis=_triple(get("orientation"), address_attribute(address, "orientation")),
        confidence=_decimal(get("confidence"), address_attribute(address, "confidence")),
        end_sites=tuple(sites),
    )


def _read_bone(element: Element, address: str, parent: int, convention: Convention) -> Joint:
    name = unescape(element.leaf(NAME) or "")
    if not name:
        raise DocumentError("a bone has no name", at=Place(element=address), remedy="Write it into its name element.")
    axis, axis_order = _axis(element.leaf(AXIS), f"{address}/axis")
    sites: list[EndSite] = []
    bones = 0
    for child in element.children:
        if child.tag == END_SITE:
            sites.append(_read_end_site(child, f"{address}/end_site[{len(sites) + 1}]", bones))
        bones += child.tag == BONE
    identity, confidence = element.attributes.get("id"), element.attributes.get("confidence")
    channels = _bone_channels(element, address, convention)
    return replace(
        _read_shared(element, name, parent, convention, channels, axis_order),
        offset=_triple(element.leaf(POSITION), f"{address}/position"),
        direction=_triple(element.leaf(DIRECTION), f"{address}/direction"),
        length=_decimal(element.leaf(LENGTH), f"{address}/length"),
        axis=axis,
        limits=tuple(unescape(limits.text.strip(WHITE_SPACE)) for limits in element.all(LIMITS)),
        bodymass=_decimal(element.leaf(BODYMASS), f"{address}/bodymass"),
        cofmass=_decimal(element.leaf(COFMASS), f"{address}/cofmass"),
        id=None if identity is None else unescape(identity),
        confidence=_decimal(confidence, address_attribute(address, "confidence")),
        end_sites=tuple(sites),
    )


def _read_shared(
    element: Element, name: str, parent: int, convention: Convention, channels: tuple[str, ...], axis_order: str
) -> Joint:
    get = element.attributes.get
    rotation_order = get("rotation_order")
    mapped, role = get("mapped"), get("role")
    return Joint(
        name=name,
        parent=parent,
        source_name=unescape(get("source_name", escape(name))),
        convention=convention,
        channels=channels,
        rotation_order=_default_order(convention, channels, axis_order)
        if rotation_order is None
        else unescape(rotation_order),
        axis_order=axis_order,
        translation=get("translation", ""),
        mapped=None if mapped is None else mapped == "true",
        role=None if role is None else unescape(role),
    )


def _read_end_site(element: Element, address: str, before: int) -> EndSite:
    offset = _triple(element.attributes["position"], address_attribute(address, "position"))
    return EndSite(offset or ("0", "0", "0"), unescape(element.attributes.get("name", "")), before)


def _bone_channels(element: Element, address: str, convention: Convention) -> tuple[str, ...]:
    tags = (DOF, ORDER) if convention is Convention.FIXED else (ORDER, DOF)
    for tag in tags:
        text = element.leaf(tag)
        if text is not None:
            return _channels(text, f"{address}/{tag}")
    return _CHANNELS_OF_BASE if convention is Convention.BASE else ()


def _channels(text: str, address: str) -> tuple[str, ...]:
    channels = []
    for word in split_list(text):
        channel = CHANNEL_OF.get(word.lower())
        if channel is None:
            raise DocumentError(
                f"unknown channel {word!r}", at=Place(element=address), remedy=f"Use {' '.join(CHANNELS)}."
            )
        if channel in channels:
            raise DocumentError(f"channel {channel} stands twice", at=Place(element=address))
        channels.append(channel)
    return tuple(channels)


def _default_order(convention: Convention, channels: tuple[str, ...], axis_order: str) -> str:
    if convention is Convention.BASE and axis_order:
        return axis_order
    return "".join(channel[1].upper() for channel in channels if channel in ROTATIONS)


def _axis(text: str | None, address: str) -> tuple[Triple | None, str]:
    """Three angles and their order, either of which may be missing."""
    words = (text or "").split()
    numbers = [word for word in words[:3] if is_decimal(word)]
    order = words[len(numbers) :]
    if len(numbers) not in (0, 3) or len(order) > 1:
        raise DocumentError(
            f"{text!r} is not three angles and their order", at=Place(element=address), remedy="Write it as 0 0 20 XYZ."
        )
    return _triple(" ".join(numbers), address) if numbers else None, unescape(order[0]) if order else ""


def _triple(text: str | None, address: str) -> Triple | None:
    if text is None:
        return None
    words = text.split()
    if len(words) != 3 or not all(map(is_decimal, words)):
        raise DocumentError(f"{text!r} is not three finite numbers", at=Place(element=address))
    return words[0], words[1], words[2]


def _decimal(text: str | None, address: str) -> str | None:
    if text is not None and not is_decimal(text):
        raise DocumentError(f"{text!r} is not a finite number", at=Place(element=address))
    return text


def _integer(text: str, address: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise DocumentError(f"{text!r} is not a whole number", at=Place(element=address))
    return int(text)


def _guess_convention(document: Element) -> Convention:
    """ASF's, where a bone states what only ASF has (Figure 2); BVH's else."""
    asf_only = any(element.tag in (DIRECTION, DOF) for _, element in addresses(document))
    return Convention.FIXED if asf_only else Convention.LISTED


def _declared(ranks: dict[int, int], count: int) -> tuple[int, ...]:
    """Joints by rank; those without one, added by an edit, come last."""
    order = tuple(sorted(range(count), key=lambda index: (ranks.get(index, count + 1), index)))
    return () if order == tuple(range(count)) else order


def _refuse_equal_names(joints: list[Joint]) -> None:
    seen: set[str] = set()
    for joint in joints:
        if joint.name in seen:
            raise DocumentError(
                f"two bones are named {joint.name!r}",
                at=Place(element="/mcml/skeleton"),
                remedy="Give each a name of its own, and state source_name if it differs.",
            )
        seen.add(joint.name)
