"""One element of a stored document: read it, change it, delete it. Nothing else of the document is written.

Addresses are canonical XPaths such as `/mcml/motion/frame[100]/frame_bone[3]/@Rx`. Changes that break the definition or
the rules beyond it are refused (DocumentError): required elements and attributes stay, counts are updated
automatically.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mcml.errors import DocumentError, Place
from mcml.files.check_names import check_frame_time, check_head
from mcml.language.addresses import MOTION, read_frame_address, split_attribute
from mcml.language.dtd import validate_by_shapes
from mcml.language.elements import Element, addresses, check_counts, from_head, joint_names, refresh_counts, to_head
from mcml.language.lexical import escape, is_decimal, unescape
from mcml.language.vocabulary import FRAME_BONE, FRAMES, MOTION_NAME
from mcml.motion.clip import ClipHead, FrameBlock
from mcml.motion.skeleton import CHANNEL_INDEX
from mcml_service.actions.editing.frame_elements import rename_frame, rewrite_frame_bone
from mcml_service.actions.editing.frame_labels import rewrite_motion_name
from mcml_service.actions.editing.frame_splicing import check_range, splice_frames
from mcml_service.actions.reading.read_element import HEAD, LEAF, missing_at
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.rows import skeleton_rows
from mcml_service.storage.transaction import Transaction

MAX_JOINTS = 65_535
"""Numbers of bones have 16 bits."""


@dataclass(frozen=True)
class Change:
    """attributes: new values, None removes one. text: of a leaf; None leaves it."""

    attributes: dict[str, str | None]
    text: str | None = None


def apply_change(tx: Transaction, stored: StoredDocument, address: str, change: Change) -> None:
    """Change attributes or text of the element at an address; the caller makes the revision."""
    leaf, place = LEAF.fullmatch(address), read_frame_address(address)
    if leaf:
        _change_motion_leaf(tx, stored, leaf[1], change)
    elif place is None:
        _edit_head(tx, stored, address, change)
    elif place.tag == FRAME_BONE:
        rewrite_frame_bone(tx, stored, place.frame, place.number, _numbers(change, address))
    elif place.tag == MOTION_NAME:
        if not change.text:
            raise DocumentError("A motion_name needs a text.", at=Place(element=address), remedy="Delete it instead.")
        rewrite_motion_name(tx, stored, place.frame, place.number, change.text)
    else:
        wanted = change.attributes.get("id")
        if not wanted or set(change.attributes) != {"id"} or change.text:
            raise DocumentError("Of a frame only its id can be changed.", at=Place(element=address))
        rename_frame(tx, stored, place.frame, wanted)


def apply_deletion(tx: Transaction, stored: StoredDocument, address: str, *, renumber: bool) -> None:
    """Delete the element or attribute at an address; the caller makes the revision.

    renumber: ids of frames that counted up by one do so again behind a frame that goes; else they keep theirs.
    """
    leaf, place = LEAF.fullmatch(address), read_frame_address(address)
    if leaf:
        if leaf[1] == FRAMES:
            raise DocumentError("motion needs its frames element.", at=Place(element=address), remedy="Delete frames.")
        tx.documents.write_content(stored.key, tx.commit, intact=False, frame_time=None)
    elif place is None:
        _edit_head(tx, stored, address, None)
    elif place.tag == FRAME_BONE:
        channels = None if place.attribute is None else {_channel(place.attribute, address): None}
        rewrite_frame_bone(tx, stored, place.frame, place.number, channels)
    elif place.tag == MOTION_NAME:
        rewrite_motion_name(tx, stored, place.frame, place.number, None)
    else:
        if place.attribute is not None:
            raise DocumentError("A frame needs its id.", at=Place(element=address))
        check_range(stored, place.frame, place.frame)
        splice_frames(tx, stored, place.frame, 1, renumber=renumber)


def _channel(name: str, address: str) -> int:
    if name == "name":
        raise DocumentError("A frame_bone needs its name.", at=Place(element=address))
    if name not in CHANNEL_INDEX:
        raise DocumentError(
            f"frame_bone has no attribute {name!r}.",
            at=Place(element=address),
            remedy=f"It has: name, {', '.join(CHANNEL_INDEX)}.",
        )
    return CHANNEL_INDEX[name]


def _numbers(change: Change, address: str) -> dict[int, float | None]:
    if change.text:
        raise DocumentError("frame_bone is empty: it has no text.", at=Place(element=address))
    result: dict[int, float | None] = {}
    for name, text in change.attributes.items():
        if text is None:
            result[_channel(name, address)] = None
            continue
        if not is_decimal(text):
            raise DocumentError(
                f"{name} is {text!r}, not a finite decimal number.",
                at=Place(element=address),
                remedy="Write a number such as -12.5 or 1e-3.",
            )
        result[_channel(name, address)] = float(text)
    return result


def _change_motion_leaf(tx: Transaction, stored: StoredDocument, tag: str, change: Change) -> None:
    address = f"{MOTION}/{tag}"
    if tag == "frames":
        raise DocumentError("frames is counted, not set.", at=Place(element=address), remedy="Insert or delete frames.")
    if change.text is None or change.attributes:
        raise DocumentError("frametime holds a text only.", at=Place(element=address), remedy="Give seconds.")
    tx.documents.write_content(stored.key, tx.commit, intact=False, frame_time=check_frame_time(change.text))


def _edit_head(tx: Transaction, stored: StoredDocument, address: str, change: Change | None) -> None:
    _, attribute = split_attribute(address)

    def edit(document: Element, target: Element) -> None:
        if change is None and attribute is None:
            children = parent_of(document, target, address).children
            del children[next(index for index, child in enumerate(children) if child is target)]
        elif change is None and attribute is not None:
            if target.attributes.pop(attribute, None) is None:
                raise missing_at(address)
        elif change is not None:
            for name, value in change.attributes.items():
                if value is None:
                    target.attributes.pop(name, None)
                else:
                    target.attributes[name] = value
            if change.text is not None:
                target.text = change.text.strip()

    edit_head(tx, stored, address, edit, counts_stated=change is not None)


def edit_head(
    tx: Transaction,
    stored: StoredDocument,
    address: str,
    edit: Callable[[Element, Element], None],
    *,
    counts_stated: bool = True,
) -> None:
    """Change header, root or skeleton; the whole head is small and is checked whole.

    edit: is given the head and the element at the address, and changes them. counts_stated: the edit may have set the
    counts that the header repeats, so they must be right; else they are made right.
    """
    match = HEAD.fullmatch(address)
    document = tx.heads.document(stored)
    before = joint_names(document)
    elements = dict(addresses(document))
    if match is None or match["element"] not in elements:
        raise missing_at(address)
    edit(document, elements[match["element"]])
    shapes = tx.tracks.shapes_in_use(stored.key)
    bones = tx.heads.bone_names(stored.key)
    _check_names(document, before, {escape(bones[bone]) for shape in shapes for bone, _ in shape}, address)
    if counts_stated:
        check_counts(document, stored.frames)
    document = refresh_counts(document, stored.frames)
    names = [bones.get(number, "") for number in range(max(bones, default=-1) + 1)]
    try:
        validate_by_shapes(document, [(shape, 1) for shape in shapes], names)
    except DocumentError as error:
        # The line numbers belong to a temporary document.
        error.at = Place(element=(error.at.element if error.at else None) or address)
        raise
    check_head(document, to_head(document, stored.frame_time), MAX_JOINTS)
    _store_head(tx, stored, document, before)


def parent_of(document: Element, target: Element, address: str) -> Element:
    """The element that holds another. DocumentError for the document element."""
    waiting = [document]
    while waiting:
        element = waiting.pop()
        if any(child is target for child in element.children):
            return element
        waiting += element.children
    raise DocumentError("The document element cannot be deleted alone.", at=Place(element=address))


def _check_names(document: Element, before: tuple[str, ...], used: set[str], address: str) -> None:
    after = joint_names(document)
    doubled = {name for name in after if after.count(name) > 1}
    if doubled:
        raise DocumentError(f"Two bones would be named {doubled.pop()!r}.", at=Place(element=address))
    if len(after) != len(before):
        lost = [name for name in before if name in used and name not in after]
        if lost:
            raise DocumentError(
                f"Frames name the bone {lost[0]!r}.",
                at=Place(element=address),
                remedy="Delete its frame_bone elements first.",
            )


def write_head(tx: Transaction, stored: StoredDocument, head: ClipHead, block: FrameBlock) -> StoredDocument:
    """Make this head the document's, before all its frames become those of the block; the caller makes the revision.

    block: with joints as the head numbers them. Raises DocumentError, LimitError where the two are no valid document.
    """
    document = refresh_counts(from_head(head), len(block))
    validate_by_shapes(document, [(shape, 1) for shape in block.shapes], list(head.skeleton.names))
    check_head(document, head, MAX_JOINTS)
    _store_head(tx, stored, document, joint_names(tx.heads.document(stored)), renamed=False)
    if head.frame_time != stored.frame_time:
        tx.documents.write_content(stored.key, tx.commit, frame_time=head.frame_time)
    return tx.documents.get(stored.uuid)


def _store_head(
    tx: Transaction, stored: StoredDocument, document: Element, before: tuple[str, ...], *, renamed: bool = True
) -> None:
    """renamed: joints keep their order, so that another name at the same place renames a joint. before: their names."""
    header, forest = document.children[0], document.children[1:]
    old = tx.heads.document(stored)
    if header != old.children[0]:
        tx.heads.write_header(stored.key, header, tx.commit)
    names = joint_names(document)
    skeleton = stored.skeleton
    if forest != old.children[1:]:
        skeleton = tx.heads.add_skeleton(stored.project_key, skeleton_rows(forest), len(names))
        # Bones keep their numbers when others go, so a number is found by the name, not by the place.
        number = {escape(name): bone for bone, name in tx.heads.bone_names(stored.key).items()}
        if renamed and len(names) == len(before):
            for was, is_now in zip(before, names, strict=True):
                if was != is_now:
                    tx.heads.rename_bone(stored.key, number[was], unescape(is_now))
        else:
            for name in set(before) - set(names):
                tx.heads.close_bone(stored.key, number[name])
            for name in names:
                if name not in before:
                    tx.heads.add_bone(stored.key, unescape(name))
    tx.documents.write_content(
        stored.key, tx.commit, intact=False, skeleton=skeleton, version=document.attributes.get("version", "")
    )
