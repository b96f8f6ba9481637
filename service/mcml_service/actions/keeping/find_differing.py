"""Find documents that the current version would read differently, with the command that fixes each."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from mcml.errors import McmlError
from mcml.formats.bvh.translation import MOST_FRAMES, differing_translations
from mcml.formats.c3d.format import quantity_labels
from mcml.motion.clip import ClipStream
from mcml.motion.guesses import changed_up
from mcml.motion.hub import HubReader, walked
from mcml.motion.skeleton import Array
from mcml_service.actions.naming.apply_names import renames
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.lists.filtering import DocumentFilter
from mcml_service.storage.transaction import Transaction

HEAD_BYTES = 1 << 20
"""Of a C3D file: its header and parameters, which have at most 255 blocks of 512 bytes, are in them."""

_NAMED = 3
"""Joints that are named of each document."""


@dataclass(frozen=True)
class Differing:
    """A difference. what: the part that is read differently. remedy: the command that fixes it."""

    id: str
    name: str
    what: str
    remedy: str


@dataclass(frozen=True)
class Looked:
    """A checked document, its differences, and the reason if it could not be read, else ""."""

    found: tuple[Differing, ...] = ()
    unread: str = ""


def look_for_differing(database: Database, project: str | None, go_on: Callable[[], bool]) -> Iterator[Looked]:
    """Check each document of a project, or of all, in a separate transaction, while `go_on` returns true.

    Only a sample of a document's frames is read; damaged documents are reported and skipped.
    """
    with database.read() as tx:
        uuids = tx.documents.uuids(DocumentFilter(project=project))
    for uuid in uuids:
        if not go_on():
            return
        try:
            with database.read() as tx:
                stored = tx.documents.find(uuid)
                looked = Looked() if stored is None else Looked(tuple(differing(tx, stored)))
        except McmlError as error:
            looked = Looked(unread=f"{uuid}: {error.what}")
        yield looked


def differing(tx: Transaction, stored: StoredDocument) -> Iterator[Differing]:
    """Yield the differences of a document."""

    def describe(what: str, remedy: str) -> Differing:
        return Differing(stored.uuid, stored.name, what, remedy)

    again = "import its file again, then make its edits there"
    if stored.intact:
        again = f"import the kept file again: mcml export {stored.uuid} --format {stored.format}, then mcml import"
    changed = renames(tx, stored)[1]
    if changed:
        told = [f"{rename.before} -> {rename.after}" for rename in changed]
        yield describe(f"names would be {_few(told)}", f"mcml names apply {stored.uuid}")
    step = max(1, -(-stored.frames // MOST_FRAMES))
    clip = read_clip(tx, stored, step=step, bare=True).clip
    skeleton = clip.head.skeleton
    if stored.format == "c3d":
        labels = set(_quantities(tx, stored))
        taken = [joint.source_name for joint in skeleton.joints if joint.source_name in labels]
        if taken:
            yield describe(f"angles, forces or the like are stored as markers: {_few(taken)}", again)
            # All other guesses depend on them, and are made again.
            return
    if not len(skeleton):
        return
    sample = _sample(clip)
    readings = differing_translations(skeleton, sample)
    if readings:
        told = [f"{skeleton.joints[rename.joint].source_name} {rename.mode}" for rename in readings]
        yield describe(f"positions would be read as {_few(told)}", again)
    up = changed_up(clip.head, _positions(clip, sample))
    if up is not None:
        yield describe(f"up was {up[0]}, and is guessed as {up[1]}", f"mcml calibrate {stored.uuid} --up {up[1]}")


def _quantities(tx: Transaction, stored: StoredDocument) -> tuple[str, ...]:
    """Labels of a kept C3D file that are no markers."""
    head = bytearray()
    for block in tx.uploads.read(stored.key, "c3d") or ():
        head += block
        if len(head) >= HEAD_BYTES:
            break
    return quantity_labels(io.BytesIO(bytes(head))) if head else ()


def _sample(clip: ClipStream) -> Array:
    """(frames, columns of the skeleton); NaN where a sample is missing."""
    columns = {column: place for place, column in enumerate(clip.head.skeleton.columns())}
    sample = []
    for block in clip.blocks():
        values = np.full((len(block), len(columns)), np.nan)
        known = [index for index, column in enumerate(block.columns) if column in columns]
        values[:, [columns[block.columns[index]] for index in known]] = block.values[:, known]
        sample.append(values)
    return np.concatenate(sample) if sample else np.empty((0, len(columns)))


def _positions(clip: ClipStream, sample: Array) -> Array:
    """(frames, joints, 3); NaN for joints of which a sample is missing; without frames of the rest pose."""
    skeleton = clip.head.skeleton
    reader = HubReader(skeleton)
    if not len(sample):
        rest = reader.rest
        return walked(skeleton, rest.offsets[None], rest.orientations[None])[0]
    hub = reader.of_values(np.nan_to_num(sample))
    positions = walked(skeleton, hub.translations, hub.rotations)[0]
    for place, (joint, _) in enumerate(skeleton.columns()):
        positions[np.isnan(sample[:, place]), joint] = np.nan
    return positions


def _few(texts: list[str]) -> str:
    more = len(texts) - _NAMED
    return ", ".join(texts[:_NAMED]) + (f" and {more} more" if more > 0 else "")
