"""Mappings of joints under names: kept, changed by who knows the present version, and used."""

from __future__ import annotations

from schemas.retarget import JointPair, Mapping
from service.actions.describe_problem import PreconditionError
from service.actions.fit_skeleton import JointMapping
from service.errors import DocumentError
from service.storage.database import Transaction
from service.storage.mappings import StoredMapping


def keep_mapping(
    tx: Transaction, project: str, name: str, pairs: list[JointPair], if_match: str | None, author: str
) -> StoredMapping:
    """Save a mapping. DocumentError for a target that is named twice; PreconditionError where another one is there."""
    targets = [pair.target for pair in pairs]
    twice = next((target for target in targets if targets.count(target) > 1), None)
    if twice is not None:
        raise DocumentError(f"The mapping names {twice!r} twice.", remedy="Give each joint one source.")
    tx.dialect.order_commits(tx.connection)
    present = tx.mappings.find(project, name)
    if present is not None:
        check_version(f"a mapping {name!r}", present.version, if_match)
    return tx.mappings.put(project, name, tuple((pair.source, pair.target) for pair in pairs), author)


def check_version(what: str, version: int, if_match: str | None) -> None:
    """PreconditionError unless the request was made for this version. what: is there, for messages."""
    if if_match is None:
        raise PreconditionError(
            f"There is {what}, and the request does not say which version it was made for.",
            428,
            f'Send the header If-Match: "{version}", or If-Match: * to change whatever is current.',
        )
    if not {tag.strip().strip('"') for tag in if_match.split(",")} & {"*", str(version)}:
        raise PreconditionError(
            f"There is {what} at version {version}, and the request was made for another one.",
            412,
            "Read it again and repeat the change.",
        )


def mapping_of(tx: Transaction, project: str, wanted: list[JointPair] | str | None) -> JointMapping | None:
    """A mapping as a request names it: its pairs, or those of a saved one. NotFoundError."""
    if isinstance(wanted, str):
        pairs = tx.mappings.get(project, wanted).pairs
        return JointMapping(tuple(JointPair(source=one, target=other) for one, other in pairs), exact=False)
    return None if wanted is None else JointMapping(tuple(wanted))


def mapping_answer(stored: StoredMapping) -> Mapping:
    return Mapping(
        name=stored.name,
        project=stored.project,
        version=stored.version,
        author=stored.author,
        changed=stored.changed,
        pairs=[JointPair(source=one, target=other) for one, other in stored.pairs],
    )
