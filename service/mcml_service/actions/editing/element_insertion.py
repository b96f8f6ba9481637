"""Insert elements into a document, or replace others.

New elements are validated in their place, then written. Inside the motion the smallest unit of writing is a frame: a
new frame_bone or motion_name rewrites its frame, unless it replaces a frame_bone of the same bone.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from mcml.errors import DocumentError, NotFoundError, Place
from mcml.language.addresses import MOTION, FrameAddress, read_frame_address
from mcml.language.element import Element
from mcml.language.elements import joint_names
from mcml.language.faults import all_faults, read_frames
from mcml.language.lexical import unescape
from mcml.motion.clip import FrameBlock
from mcml_service.actions.editing.frame_splicing import check_range, splice_frames
from mcml_service.actions.editing.single_element import Change, apply_change, edit_head, parent_of
from mcml_service.actions.reading.read_element import frame_at
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

Where = Literal["before", "after", "into"]


def insert_elements(
    tx: Transaction,
    stored: StoredDocument,
    address: str,
    where: Where,
    elements: list[Element],
    *,
    renumber: bool = True,
) -> None:
    """Put elements before or after the element at an address, or into it, at its end. Writes no revision.

    renumber: frames that come, and those behind them, count on where ids counted up by one.
    DocumentError where `mcml.dtd` or the rules beyond it do not allow them there.
    """
    inside = _element_in_frames(address)
    if inside and not inside.tag and where != "into":
        check_range(stored, inside.frame, inside.frame)
        _splice(tx, stored, inside.frame + (where == "after"), 0, elements, renumber)
    elif address == MOTION and where == "into" and all(element.tag == "frame" for element in elements):
        _splice(tx, stored, stored.frames + 1, 0, elements, renumber)
    elif inside:
        element = frame_at(tx, stored, inside.frame)
        if not inside.tag:
            place = _end_of(element, elements)
        else:
            place = _place(element, inside.tag, inside.number, address) + (where == "after")
            if where == "into":
                raise DocumentError(f"{inside.tag} holds no elements.", at=Place(element=address))
        element.children[place:place] = elements
        _splice(tx, stored, inside.frame, 1, [element], renumber=False)
    elif address.startswith(MOTION):
        raise DocumentError("Only frames can be put here.", at=Place(element=address), remedy="See mcml.dtd.")
    else:
        _into_head(tx, stored, address, where, elements)


def _element_in_frames(address: str) -> FrameAddress | None:
    place = read_frame_address(address)
    return None if place is None or place.attribute is not None else place


def replace_element(tx: Transaction, stored: StoredDocument, address: str, elements: list[Element]) -> None:
    """Replace the element at an address by others. Writes no revision."""
    inside = _element_in_frames(address)
    if inside and not inside.tag:
        check_range(stored, inside.frame, inside.frame)
        _splice(tx, stored, inside.frame, 1, elements, renumber=False)
    elif inside:
        element = frame_at(tx, stored, inside.frame)
        place = _place(element, inside.tag, inside.number, address)
        change = _change(element.children[place], elements)
        if change is not None:
            apply_change(tx, stored, address, change)
            return
        element.children[place : place + 1] = elements
        _splice(tx, stored, inside.frame, 1, [element], renumber=False)
    elif address.startswith(MOTION):
        raise DocumentError("This element is not replaced.", at=Place(element=address), remedy="Change its text.")
    else:

        def edit(document: Element, target: Element) -> None:
            children = parent_of(document, target, address).children
            place = next(index for index, child in enumerate(children) if child is target)
            children[place : place + 1] = elements

        edit_head(tx, stored, address, edit)


def _change(old: Element, new: list[Element]) -> Change | None:
    """Return the change between two frame_bones of the same bone: it writes less than a rewritten frame."""
    if [old.tag] != [element.tag for element in new] or old.tag != "frame_bone" or new[0].text or new[0].children:
        return None
    (element,) = new
    if element.attributes.get("name") != old.attributes["name"]:
        return None
    gone: dict[str, str | None] = dict.fromkeys(old.attributes.keys() - element.attributes.keys())
    return Change(gone | {name: text for name, text in element.attributes.items() if name != "name"})


def _into_head(tx: Transaction, stored: StoredDocument, address: str, where: Where, elements: list[Element]) -> None:
    def edit(document: Element, target: Element) -> None:
        if where == "into":
            target.children += elements
            return
        children = parent_of(document, target, address).children
        place = next(index for index, child in enumerate(children) if child is target) + (where == "after")
        children[place:place] = elements

    edit_head(tx, stored, address, edit)


def _place(frame: Element, tag: str, number: int, address: str) -> int:
    """Return the index among the children of a frame of the number-th element with a tag."""
    places = [index for index, child in enumerate(frame.children) if child.tag == tag]
    if not 1 <= number <= len(places):
        raise NotFoundError("The document has nothing at this address.", at=Place(element=address))
    return places[number - 1]


def _end_of(frame: Element, elements: list[Element]) -> int:
    """Return the insertion index at the end of a frame: motion names come before the frame_bones."""
    names = len(frame.all("motion_name"))
    return names if all(element.tag == "motion_name" for element in elements) else len(frame.children)


def _splice(
    tx: Transaction, stored: StoredDocument, at: int, removed: int, frames: list[Element], renumber: bool
) -> None:
    splice_frames(tx, stored, at, removed, _blocks(tx, stored, at, frames), renumber=renumber)


def _blocks(tx: Transaction, stored: StoredDocument, at: int, frames: list[Element]) -> list[FrameBlock]:
    """Frames as blocks of the document's bones, read and validated as a document of these frames would be.

    at: where the first of them goes. DocumentError with every fault and its address there.
    """
    head = tx.heads.document(stored)
    try:
        blocks = read_frames(head, frames)
    except DocumentError as error:
        raise all_faults(head, frames, at, error) from None
    numbers = {name: number for number, name in tx.heads.bone_names(stored.key).items()}
    bones = [numbers[unescape(name)] for name in joint_names(head)]
    return [
        replace(
            block,
            columns=tuple((bones[joint], channel) for joint, channel in block.columns),
            shapes=tuple(tuple((bones[joint], bits) for joint, bits in shape) for shape in block.shapes),
        )
        for block in blocks
    ]
