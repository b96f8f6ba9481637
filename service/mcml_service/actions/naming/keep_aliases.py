"""Joint names of a project: check, store, and change them with the current version."""

from __future__ import annotations

from collections.abc import Sequence

from mcml.errors import DocumentError
from mcml.language.joint_names import alias_key, check_name, table
from mcml_schemas.names import Alias, AliasTable, Rename
from mcml_service.actions.checking.preconditions import check_match
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.work.aliases import StoredAliases


def keep_aliases(
    tx: Transaction, project: str, items: Sequence[Alias], if_match: str | None, author: str
) -> StoredAliases:
    """Save the aliases of a project.

    Raises VocabularyError for names that are not MCML's, DocumentError for duplicates.
    """
    seen: dict[str, str] = {}
    for item in items:
        check_name(item.name)
        key = alias_key(item.source)
        if not key or "\0" in item.source:
            raise DocumentError(f"{item.source!r} is no name of a joint.", remedy="Give letters or digits.")
        if key in seen:
            raise DocumentError(
                f"{seen[key]!r} and {item.source!r} are the same name: case and punctuation do not count.",
                remedy="Say each one once.",
            )
        seen[key] = item.source
    tx.order()
    present = tx.aliases.of(project)
    if present.version:
        check_match(if_match, present.version, "table of aliases", "version")
    return tx.aliases.put(project, tuple((item.source, item.name) for item in items), author)


def add_aliases(tx: Transaction, project: str, renamed: Sequence[Rename], author: str) -> None:
    """Add the names that joints were given to the aliases of a project; older aliases of the same joints go."""
    known = {row.name for row in table()}
    added = {alias_key(item.source): (item.source, item.after) for item in renamed if item.after in known}
    if added:
        tx.order()
        kept = [pair for pair in tx.aliases.of(project).pairs if alias_key(pair[0]) not in added]
        tx.aliases.put(project, (*kept, *added.values()), author)


def remove_aliases(tx: Transaction, project: str, if_match: str | None) -> None:
    """Take all aliases of a project away. Documents keep the names that they have."""
    tx.order()
    tx.projects.get(project)
    present = tx.aliases.of(project)
    if present.version:
        check_match(if_match, present.version, "table of aliases", "version")
        tx.aliases.remove(project)


def alias_table(stored: StoredAliases) -> AliasTable:
    return AliasTable(
        project=stored.project,
        version=stored.version,
        author=stored.author,
        changed=stored.changed,
        items=[Alias(source=source, name=name) for source, name in stored.pairs],
    )
