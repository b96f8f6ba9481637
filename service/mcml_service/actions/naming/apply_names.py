"""New names for joints of stored documents: those that an import would give now, and those that a person chooses."""

from __future__ import annotations

from collections.abc import Sequence

from mcml.errors import DocumentError
from mcml.files.shared_skeleton import moving_root
from mcml.language import joint_names
from mcml.language.element import Element, addresses
from mcml.language.elements import to_head
from mcml.language.lexical import escape
from mcml.language.vocabulary import BONE, NAME, ROOT
from mcml.motion.rigs.skeletons import recognise_clip
from mcml.motion.skeleton import Joint, Skeleton
from mcml_schemas.names import JointChoice, Rename
from mcml_service.actions.editing.single_element import edit_head
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction


def renames(tx: Transaction, stored: StoredDocument) -> tuple[Skeleton, list[Rename]]:
    """Return (the skeleton with the names and roles that an import would give it now, those that differ from the
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
        Rename(source=new.source_name, before=old.name, after=new.name, role=new.role)
        for old, new in zip(before.joints, after.joints, strict=True)
        if (old.name, old.confidence, old.role) != (new.name, new.confidence, new.role)
    ]
    return after, changed


def apply_names(tx: Transaction, stored: StoredDocument) -> tuple[StoredDocument, list[Rename]]:
    """Rename joints as one revision, which undo takes back; none where nothing is renamed. Numbers stay."""
    skeleton, changed = renames(tx, stored)
    return _keep(tx, stored, skeleton, changed)


def name_joints(
    tx: Transaction, stored: StoredDocument, items: Sequence[JointChoice]
) -> tuple[StoredDocument, list[Rename]]:
    """Give joints names that a person chose, as one revision; none where nothing is renamed.

    Raises DocumentError for joints that the document does not have, for markers and blend shapes; VocabularyError for
    names that are not MCML's.
    """
    before = to_head(tx.heads.document(stored), stored.frame_time).skeleton
    chosen = {}
    for item in items:
        if item.joint not in before.names:
            raise DocumentError(
                f"The document has no joint {item.joint!r}.", remedy=f"It has: {', '.join(before.names[:60])}."
            )
        index = before.names.index(item.joint)
        if not before.joints[index].has_axes:
            raise DocumentError(
                f"{item.joint!r} is no joint.", remedy="Markers and blend shapes keep the names of their file."
            )
        chosen[index] = item.name
    after = joint_names.rename_joints(before, chosen)
    changed = [
        Rename(source=new.source_name, before=old.name, after=new.name, role=new.role)
        for old, new in zip(before.joints, after.joints, strict=True)
        if (old.name, old.confidence, old.mapped) != (new.name, new.confidence, new.mapped)
    ]
    return _keep(tx, stored, after, changed)


def _keep(
    tx: Transaction, stored: StoredDocument, skeleton: Skeleton, changed: list[Rename]
) -> tuple[StoredDocument, list[Rename]]:
    if changed:

        def edit(document: Element, _: Element) -> None:
            joints = [element for _, element in addresses(document) if element.tag in (ROOT, BONE)]
            for element, joint in zip(joints, skeleton.joints, strict=True):
                _write(element, joint)

        edit_head(tx, stored, "/mcml/skeleton", edit)
        told = ", ".join(
            f"{item.before} -> {item.after}" if item.before != item.after else f"{item.after}: {item.role}"
            for item in changed
        )
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
    element.attributes.pop("mapped", None)
    if joint.mapped is not None:
        element.attributes["mapped"] = "true" if joint.mapped else "false"
    element.attributes.pop("confidence", None)
    if joint.confidence is not None:
        element.attributes["confidence"] = joint.confidence
    element.attributes.pop("role", None)
    if joint.role is not None:
        element.attributes["role"] = joint.role
