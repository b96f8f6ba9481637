"""The present names of joints for a document that was stored with others: the table, and its project's aliases."""

from __future__ import annotations

from mcml.files.shared_skeleton import moving_root
from mcml.language import joint_names
from mcml.language.element import Element, addresses
from mcml.language.lexical import escape
from mcml.language.vocabulary import BONE, NAME, ROOT
from mcml.motion.rigs.skeletons import recognise_clip
from mcml.motion.skeleton import Joint, Skeleton
from mcml_schemas.names import Rename
from mcml_service.actions.editing.single_element import edit_head
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


def renames(tx: Transaction, stored: StoredDocument) -> tuple[Skeleton, list[Rename]]:
    """Return (the skeleton with the names that an import would give it now, the names that differ from the
    document's).
    """
    clip = read_clip(tx, stored, labelled=False).clip
    before = clip.head.skeleton
    if all(joint.mapped is None for joint in before.joints):
        # Written in MCML by hand: it keeps its names, as on import.
        return before, []
    rig = recognise_clip(clip)
    after, _ = joint_names.named(before, tx.aliases.of(stored.project).pairs, moving_root(clip, rig), rig)
    changed = [
        Rename(source=new.source_name, before=old.name, after=new.name)
        for old, new in zip(before.joints, after.joints, strict=True)
        if (old.name, old.confidence) != (new.name, new.confidence)
    ]
    return after, changed


def apply_names(tx: Transaction, stored: StoredDocument) -> tuple[StoredDocument, list[Rename]]:
    """Rename joints as one revision, which undo takes back; none where nothing is renamed. Numbers stay."""
    skeleton, changed = renames(tx, stored)
    if changed:

        def edit(document: Element, _: Element) -> None:
            joints = [element for _, element in addresses(document) if element.tag in (ROOT, BONE)]
            for element, joint in zip(joints, skeleton.joints, strict=True):
                _write(element, joint)

        edit_head(tx, stored, "/mcml/skeleton", edit)
        told = ", ".join(f"{item.before} -> {item.after}" for item in changed)
        tx.documents.add_revision(stored, "names", told[:200])
    return tx.documents.get(stored.uuid), changed


def _write(element: Element, joint: Joint) -> None:
    name = escape(joint.name)
    if element.tag == ROOT:
        element.attributes["name"] = name
    else:
        next(child for child in element.children if child.tag == NAME).text = name
    element.attributes.pop("source_name", None)
    if joint.source_name != joint.name:
        element.attributes["source_name"] = escape(joint.source_name)
    element.attributes["mapped"] = "true" if joint.mapped else "false"
    element.attributes.pop("confidence", None)
    if joint.confidence is not None:
        element.attributes["confidence"] = joint.confidence
