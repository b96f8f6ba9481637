"""A stored document as a clip again: its head, and its frames as a stream."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

from mcml.errors import NotFoundError
from mcml.language.elements import Element, format_of, mcml_attributes, refresh_counts, to_head
from mcml.language.vocabulary import MCML
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.skeleton import Skeleton
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.documents.motion_names import names_of_frames
from mcml_service.storage.transaction import Transaction

Skeletons: TypeAlias = dict[tuple[int, str], Skeleton]
"""By the key of the skeleton in the store, and the format whose conventions it has."""


@dataclass(frozen=True)
class StoredClip:
    """document: the `mcml` element without motion. names: of each joint. clip: streams frames first to last.

    Lives as long as the transaction it was read in.
    """

    stored: StoredDocument | Listed
    document: Element
    names: tuple[str, ...]
    clip: ClipStream
    first: int
    last: int


def read_clip(
    tx: Transaction,
    stored: StoredDocument | Listed,
    *,
    first: int = 1,
    last: int | None = None,
    step: int = 1,
    labelled: bool = True,
    bare: bool = False,
    skeletons: Skeletons | None = None,
) -> StoredClip:
    """Frames first to last (positions from 1, inclusive; default all). NotFoundError outside the document.

    labelled: with their motion names. bare: samples alone, without names, shapes and ids. skeletons: those of documents
    that were read before, of which the document then has no elements; this one's is added.
    """
    last = stored.frames if last is None else last
    if stored.frames and not 1 <= first <= last <= stored.frames:
        raise NotFoundError(
            f"Frames {first} to {last} are not in {stored.name!r}, a document of {stored.frames} frames.",
            remedy="Frame numbers are positions, from 1, both ends included.",
        )
    frames = len(range(first, last + 1, step))
    header = tx.heads.header(stored.key)
    form = stored.skeleton, format_of(header)
    known = None if skeletons is None else skeletons.get(form)
    elements = tx.heads.skeleton(stored.skeleton) if known is None else []
    document = Element(MCML, mcml_attributes(stored.version), "", [header, *elements])
    if known is None:
        document = refresh_counts(document, frames)
    head = to_head(document, stored.frame_time, known)
    if skeletons is not None:
        skeletons[form] = head.skeleton
    head = head.every(step)
    columns = head.skeleton.columns()
    names = head.skeleton.names
    joint_of = {bone: names.index(name) for bone, name in tx.heads.bone_names(stored.key).items() if name in names}
    same = all(bone == joint for bone, joint in joint_of.items())
    bone_of = {joint: bone for bone, joint in joint_of.items()}
    bone_columns = columns if same else [(bone_of[joint], channel) for joint, channel in columns]

    def blocks() -> Iterator[FrameBlock]:
        position = first
        for block in tx.tracks.blocks(stored.key, first, last, columns=bone_columns, step=step, bare=bare):
            if not same:
                block = _renumber(block, joint_of)
            if labelled and not bare:
                end = position + (len(block) - 1) * step
                spans = tx.spans.of(stored.key, position, end)
                block = replace(block, motion_names=names_of_frames(spans, range(position, end + 1, step)))
                position = end + step
            yield block

    clip = ClipStream(head, blocks, frames)
    return StoredClip(stored, document, names, clip, first, last)


def _renumber(block: FrameBlock, joint_of: Mapping[int, int]) -> FrameBlock:
    """The block with joints as the skeleton now numbers them; bones keep their number when a skeleton is edited."""
    return replace(
        block,
        columns=tuple((joint_of[bone], channel) for bone, channel in block.columns),
        shapes=tuple(tuple((joint_of[bone], bits) for bone, bits in shape) for shape in block.shapes),
    )
