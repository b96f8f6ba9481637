"""Names of joints: aliases of a project, mappings between rigs, and renaming joints of existing documents."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mcml_schemas.examples import PROJECT
from mcml_schemas.names import AliasTable, AppliedNames, JointChoices, SavedAliases
from mcml_schemas.retarget import Mapping, MappingPage, SavedMapping
from mcml_service.actions.checking.preconditions import check_match
from mcml_service.actions.composing.keep_mapping import keep_mapping, mapping_answer
from mcml_service.actions.naming import apply_names as applying
from mcml_service.actions.naming import keep_aliases
from mcml_service.operations.arguments import DocumentId, IfMatch, InProject, Page, find_for_write
from mcml_service.operations.call import Call

OfProject = Annotated[
    str, Field(min_length=1, max_length=256, description="Project whose files call joints so", examples=[PROJECT])
]
Keeper = Annotated[
    str, Field(min_length=1, max_length=256, description="Project that keeps the mapping", examples=[PROJECT])
]
MappingName = Annotated[
    str, Field(min_length=1, max_length=1024, description="Name of the mapping", examples=["cmu to robot"])
]


def get_aliases(call: Call, project: OfProject = "default") -> AliasTable:
    with call.database.read() as tx:
        return _table(call, keep_aliases.alias_table(tx.aliases.of(project)))


def save_aliases(
    call: Call, aliases: SavedAliases, project: OfProject = "default", if_match: IfMatch = None
) -> AliasTable:
    """For imports to come. A present table is changed with `If-Match`, its version."""
    with call.database.write(call.author) as tx:
        kept = keep_aliases.keep_aliases(tx, project, aliases.items, if_match, call.author)
        return _table(call, keep_aliases.alias_table(kept))


def delete_aliases(call: Call, project: OfProject = "default", if_match: IfMatch = None) -> None:
    """Documents keep the names that they have."""
    with call.database.write(call.author) as tx:
        keep_aliases.remove_aliases(tx, project, if_match)


def apply_names(
    call: Call,
    id: DocumentId,
    dry_run: Annotated[bool, Field(description="Preview the renames without changing anything")] = False,
    if_match: IfMatch = None,
) -> AppliedNames:
    if dry_run:
        with call.database.read() as tx:
            stored = tx.documents.get(id)
            items = applying.renames(tx, stored)[1]
    else:
        with call.database.write(call.author) as tx:
            stored, items = applying.apply_names(tx, find_for_write(tx, id, if_match))
    return AppliedNames(document=id, revision=stored.revision, items=items)


def name_joints(call: Call, id: DocumentId, choices: JointChoices, if_match: IfMatch = None) -> AppliedNames:
    """`GET /joint-names` lists the names. Positions and rotations stay; questions, analyses and retargeting use the new
    names.
    """
    with call.database.write(call.author) as tx:
        before = find_for_write(tx, id, if_match)
        stored, items = applying.name_joints(tx, before, choices.items)
        if choices.remember:
            keep_aliases.add_aliases(tx, stored.project, items, call.author)
    return AppliedNames(document=id, revision=stored.revision, items=items)


def list_mappings(call: Call, page: Page, project: InProject = None) -> MappingPage:
    after = page.after(str, str)
    with call.database.read() as tx:
        mappings = tx.mappings.page(project, None if after is None else (after[0], after[1]), page.most(call) + 1)
    shown, more = page.cut(call, mappings, lambda stored: (stored.project, stored.name))
    return MappingPage(items=[mapping_answer(item) for item in shown], next_cursor=more)


def get_mapping(call: Call, name: MappingName, project: Keeper = "default") -> Mapping:
    with call.database.read() as tx:
        return _mapping(call, mapping_answer(tx.mappings.get(project, name)))


def save_mapping(
    call: Call, name: MappingName, mapping: SavedMapping, project: Keeper = "default", if_match: IfMatch = None
) -> Mapping:
    """A present one is changed with `If-Match` and its version."""
    with call.database.write(call.author) as tx:
        made = mapping_answer(keep_mapping(tx, project, name, mapping.pairs, if_match, call.author))
    call.made = made.version == 1
    return _mapping(call, made)


def delete_mapping(call: Call, name: MappingName, project: Keeper = "default", if_match: IfMatch = None) -> None:
    """Documents made with it stay."""
    with call.database.write(call.author) as tx:
        tx.order()
        stored = tx.mappings.get(project, name)
        check_match(if_match, stored.version, "mapping", "version")
        tx.mappings.remove(stored)


def _table(call: Call, aliases: AliasTable) -> AliasTable:
    call.tag = str(aliases.version)
    return aliases


def _mapping(call: Call, mapping: Mapping) -> Mapping:
    call.tag = str(mapping.version)
    return mapping
