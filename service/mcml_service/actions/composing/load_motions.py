"""Stored clips as analyses see them: one rotation and one translation a joint and frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.errors import DocumentError, McmlError
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.conventions.convert import convert
from mcml.motion.hub import HubReader
from mcml.motion.retargeting.move_character import with_body
from mcml.motion.retargeting.retarget import retarget
from mcml.motion.skeleton import Convention, Skeleton
from mcml.motion.units import metres_of, reading_of
from mcml_service.actions.checking.check_timed import seconds_of
from mcml_service.actions.composing.fit_skeleton import give_skeleton, match_joints, upright
from mcml_service.actions.editing.motion_processing import Whole, read_whole
from mcml_service.analysis.interface import Motion, Progress, silent
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

Input = dict[str, Any]
"""{"document": uuid, "revision": number}: a clip that an analysis reads, and at which revision."""


def load_motions(
    tx: Transaction, inputs: Sequence[Input], progress: Progress = silent, skeleton: Input | None = None
) -> list[Motion]:
    """The clips in the order of their document ids. skeleton: a document on whose skeleton all of them are brought.

    DocumentError for a clip without frames or frame time, and with a skeleton for markers; ConversionError where no
    joints match.
    """
    motions: list[Motion] = []
    body = None if skeleton is None else read_whole(*find_document(tx, skeleton), 1, 1)
    for item in sorted(inputs, key=lambda item: str(item["document"])):
        progress("reading clips", len(motions) / len(inputs))
        motions.append(_motion(*find_document(tx, item), body))
    return motions


def find_document(tx: Transaction, item: Input) -> tuple[Transaction, StoredDocument]:
    """Return the transaction to read a document at a revision with, and the document then."""
    current = tx.documents.get(item["document"], deleted=True)
    then = tx.at_commit(tx.documents.commit_of(current.key, item["revision"]))
    return then, then.documents.get(item["document"], deleted=True)


def _motion(then: Transaction, stored: StoredDocument, body: Whole | None) -> Motion:
    seconds = seconds_of(stored)
    if not stored.frames:
        raise DocumentError(f"{stored.name} ({stored.uuid}) has no frames.", remedy="Leave it out.")
    source = read_clip(then, stored).clip if body is None else _retarget_clip(then, stored, seconds, body)
    if not len(source.head.skeleton):
        raise DocumentError(f"{stored.name} ({stored.uuid}) has no joints.", remedy="Leave it out.")
    presence: list[NDArray[np.bool_]] = []

    def watch() -> Iterator[FrameBlock]:
        presence.clear()
        for block in source.blocks():
            presence.append(_present(source.head.skeleton, block))
            yield block

    clip = ClipStream(source.head, watch, source.frames)
    markers = all(joint.convention is Convention.MARKER for joint in source.head.skeleton.joints)
    clip = clip if markers else convert(clip, Convention.LISTED)
    skeleton = clip.head.skeleton
    reader = HubReader(skeleton, reading_of(clip.head))
    blocks = [reader.read(block) for block in clip.blocks()]
    present = np.concatenate(presence)
    place = {name: index for index, name in enumerate(source.head.skeleton.names)}
    return Motion(
        document=stored.uuid,
        revision=stored.revision,
        name=stored.name,
        skeleton=skeleton,
        frame_time=seconds,
        rotations=np.concatenate([block.rotations for block in blocks]),
        translations=np.concatenate([block.translations for block in blocks]),
        # Conversion may have added joints, which are always there.
        present=None
        if present.all()
        else np.stack([present[:, place[n]] if n in place else np.ones(len(present), bool) for n in skeleton.names], 1),
        metres=metres_of(source.head),
        up=source.head.fields.get("global_axis_of_gravity", "").strip().upper()[-1:] or None,
        properties={name: (value, unit) for name, value, unit in source.head.properties},
        labels=tuple((span.name, span.first - 1, span.last - 1) for span in then.spans.of(stored.key)),
    )


def _retarget_clip(then: Transaction, stored: StoredDocument, seconds: float, body: Whole) -> ClipStream:
    """Retarget a clip to the skeleton of a body; a clip with this skeleton is unchanged."""
    whole = read_whole(then, stored)
    try:
        whole, _ = give_skeleton(whole)
    except McmlError as error:
        raise DocumentError(
            f"{stored.name} ({stored.uuid}): {error.what}", remedy="Leave it out, or do not name a skeleton."
        ) from error
    if whole.head.skeleton == body.head.skeleton:
        return read_clip(then, stored).clip
    whole, _ = upright(whole, body.up)
    source, two = whole.head.skeleton, body.head.skeleton
    made = retarget(
        source,
        whole.block,
        two,
        match_joints(source, two, None),
        seconds,
        reading=whole.reading,
        target_reading=body.reading,
        up=body.up,
    )
    head = replace(with_body(whole.head, body.head), frame_time=stored.frame_time)
    return ClipStream(head, lambda: iter([made.block]), len(made.block))


def _present(skeleton: Skeleton, block: FrameBlock) -> NDArray[np.bool_]:
    """(n, J): where the block has a sample of every channel of a joint."""
    here = ~np.isnan(block.values)
    held = {column: index for index, column in enumerate(block.columns)}
    present = np.ones((len(block), len(skeleton)), dtype=bool)
    for joint, channel in skeleton.columns():
        index = held.get((joint, channel))
        present[:, joint] &= False if index is None else here[:, index]
    return present
