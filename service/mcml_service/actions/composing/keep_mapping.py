"""Saved mappings of joints: store, change with the current version, and use them."""

from __future__ import annotations

from mcml.errors import DocumentError
from mcml_schemas.retarget import JointPair, Mapping
from mcml_service.actions.checking.preconditions import check_match
from mcml_service.actions.composing.fit_skeleton import JointMapping
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.work.mappings import StoredMapping


def keep_mapping(
    tx: Transaction, project: str, name: str, pairs: list[JointPair], if_match: str | None, author: str
) -> StoredMapping:
    """Save a mapping.

    Raises DocumentError for a target that is named twice; PreconditionError if the version is not current.
    """
    targets = [pair.target for pair in pairs]
    twice = next((target for target in targets if targets.count(target) > 1), None)
    if twice is not None:
        raise DocumentError(f"The mapping names {twice!r} twice.", remedy="Give each joint one source.")
    tx.order()
    present = tx.mappings.find(project, name)
    if present is not None:
        check_match(if_match, present.version, "mapping", "version")
    return tx.mappings.put(project, name, tuple((pair.source, pair.target) for pair in pairs), author)


def mapping_of(tx: Transaction, project: str, wanted: list[JointPair] | str | None) -> JointMapping | None:
    """A mapping as a request names it: its pairs, or those of a saved one. NotFoundError."""
    if isinstance(wanted, str):
        pairs = tx.mappings.get(project, wanted).pairs
        return JointMapping(tuple(JointPair(source=source, target=other) for source, other in pairs), exact=False)
    return None if wanted is None else JointMapping(tuple(wanted))


def mapping_answer(stored: StoredMapping) -> Mapping:
    return Mapping(
        name=stored.name,
        project=stored.project,
        version=stored.version,
        author=stored.author,
        changed=stored.changed,
        pairs=[JointPair(source=source, target=other) for source, other in stored.pairs],
    )
