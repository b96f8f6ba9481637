"""Saved items of projects: queries, collections of documents, colours of motion names; and the vocabulary of a
project.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mcml.errors import DocumentError
from mcml_schemas.examples import PROJECT
from mcml_schemas.querying.saved import (
    Collection,
    CollectionPage,
    CollectionToSave,
    Colours,
    ColoursToSave,
    QueryToSave,
    SavedQuery,
    SavedQueryPage,
    Vocabulary,
    VocabularyToSave,
    VocabularyWord,
)
from mcml_service.actions.checking.preconditions import check_match
from mcml_service.operations.arguments import IfMatch, InProject, Page
from mcml_service.operations.call import Call
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.work.saved import Kind, StoredThing, filter_of

Keeper = Annotated[
    str, Field(min_length=1, max_length=256, description="Project that keeps it; made if new", examples=[PROJECT])
]
Name = Annotated[
    str, Field(min_length=1, max_length=1024, pattern=r"^[^/]+$", description="Its name", examples=["bent legs"])
]
ALL = ""
"""The name under which the colours and the vocabulary of a project are kept: it has one table of each."""


def list_saved_queries(call: Call, page: Page, project: InProject = None) -> SavedQueryPage:
    things, more = _page(call, "query", page, project)
    return SavedQueryPage(items=[_query(thing) for thing in things], next_cursor=more)


def get_saved_query(call: Call, name: Name, project: Keeper = "default") -> SavedQuery:
    with call.database.read() as tx:
        thing = tx.saved.get("query", project, name)
    call.set_tag(str(thing.version))
    return _query(thing)


def save_query(
    call: Call, name: Name, query: QueryToSave, project: Keeper = "default", if_match: IfMatch = None
) -> SavedQuery:
    """A present one is changed with `If-Match`, its version."""
    from mcml_service.xpath.language.parse import parse

    parse(query.q, query.variables)
    return _query(_put(call, "query", project, name, query.model_dump(), if_match))


def delete_query(call: Call, name: Name, project: Keeper = "default", if_match: IfMatch = None) -> None:
    _delete(call, "query", project, name, if_match)


def list_collections(call: Call, page: Page, project: InProject = None) -> CollectionPage:
    """Without the documents that are in them."""
    things, more = _page(call, "collection", page, project)
    return CollectionPage(items=[_collection(thing) for thing in things], next_cursor=more)


def get_collection(call: Call, name: Name, project: Keeper = "default") -> Collection:
    """With the documents that are in it now."""
    with call.database.read() as tx:
        thing = tx.saved.get("collection", project, name)
        members = tx.saved.members(thing)
    call.tag = str(thing.version)
    return _collection(thing, members)


def save_collection(
    call: Call, name: Name, collection: CollectionToSave, project: Keeper = "default", if_match: IfMatch = None
) -> Collection:
    """Use `collection:NAME` or `collection:PROJECT/NAME` in place of ids of documents.

    To change an existing collection, send its version in `If-Match`.
    """
    content = collection.model_dump(exclude_none=True)
    if "where" in content:
        filter_of(content["where"])
    thing = _put(call, "collection", project, name, content, if_match)
    with call.database.read() as tx:
        return _collection(thing, tx.saved.members(thing))


def delete_collection(call: Call, name: Name, project: Keeper = "default", if_match: IfMatch = None) -> None:
    """The documents stay."""
    _delete(call, "collection", project, name, if_match)


def get_colours(call: Call, project: Keeper = "default") -> Colours:
    with call.database.read() as tx:
        thing = tx.saved.find("colours", project, ALL)
    colours = thing or StoredThing(project, ALL, 0, "", "", {"items": {}})
    call.tag = str(colours.version)
    return _colours(colours)


def save_colours(call: Call, colours: ColoursToSave, project: Keeper = "default", if_match: IfMatch = None) -> Colours:
    """All of the project. Present ones are changed with `If-Match`, their version."""
    return _colours(_put(call, "colours", project, ALL, colours.model_dump(), if_match))


def get_vocabulary(call: Call, project: Keeper = "default") -> Vocabulary:
    """Other names are allowed there, too."""
    with call.database.read() as tx:
        thing = tx.saved.find("vocabulary", project, ALL)
    vocabulary = thing or StoredThing(project, ALL, 0, "", "", {"items": []})
    call.tag = str(vocabulary.version)
    return _vocabulary(vocabulary)


def save_vocabulary(
    call: Call, vocabulary: VocabularyToSave, project: Keeper = "default", if_match: IfMatch = None
) -> Vocabulary:
    """All of the project, each name in the form in which documents keep it. A present one is changed with `If-Match`,
    its version."""
    items = _check_vocabulary(vocabulary.items)
    return _vocabulary(_put(call, "vocabulary", project, ALL, {"items": items}, if_match))


def delete_vocabulary(call: Call, project: Keeper = "default", if_match: IfMatch = None) -> None:
    """Documents keep the names that they have."""
    _delete(call, "vocabulary", project, ALL, if_match)


def _check_vocabulary(words: list[VocabularyWord]) -> list[dict[str, object]]:
    """Return the words in their stored form.

    Raises VocabularyError for impossible names, DocumentError for a repeated one.
    """
    from mcml.language.motion_names import canonical

    items: dict[str, dict[str, object]] = {}
    for word in words:
        name = canonical(word.name)
        if name in items:
            raise DocumentError(
                f"{name!r} is there twice.", remedy="Say each name once; synonyms of a movement are one name."
            )
        items[name] = word.model_copy(update={"name": name}).model_dump(exclude_none=True)
    return list(items.values())


def _page(call: Call, kind: Kind, page: Page, project: str | None) -> tuple[list[StoredThing], str | None]:
    after = page.after(str, str)
    with call.database.read() as tx:
        things = tx.saved.page(kind, project, None if after is None else (after[0], after[1]), page.most(call) + 1)
    shown, more = page.cut(call, things, lambda thing: (thing.project, thing.name))
    return list(shown), more


def _put(
    call: Call, kind: Kind, project: str, name: str, content: dict[str, object], if_match: str | None
) -> StoredThing:
    with call.database.write(call.author) as tx:
        _check(tx, kind, project, name, if_match)
        call.made = tx.saved.find(kind, project, name) is None
        thing = tx.saved.put(kind, project, name, content, call.author)
    call.tag = str(thing.version)
    return thing


def _delete(call: Call, kind: Kind, project: str, name: str, if_match: str | None) -> None:
    with call.database.write(call.author) as tx:
        thing = tx.saved.get(kind, project, name)
        _check(tx, kind, project, name, if_match)
        tx.saved.remove(kind, thing)


def _check(tx: Transaction, kind: Kind, project: str, name: str, if_match: str | None) -> None:
    # Wait for a concurrent save of the same name.
    tx.order()
    thing = tx.saved.find(kind, project, name)
    if thing is not None:
        check_match(if_match, thing.version, kind, "version")


def _query(thing: StoredThing) -> SavedQuery:
    return SavedQuery(**_about(thing), **thing.content)


def _collection(thing: StoredThing, members: list[str] | None = None) -> Collection:
    content = {name: value for name, value in thing.content.items() if name != "documents"}
    total = None if members is None else len(members)
    return Collection(**_about(thing), **content, documents=members, total=total)


def _colours(thing: StoredThing) -> Colours:
    facts = {name: value for name, value in _about(thing).items() if name != "name"}
    return Colours(**facts, items=thing.content["items"])


def _vocabulary(thing: StoredThing) -> Vocabulary:
    facts = {name: value for name, value in _about(thing).items() if name != "name"}
    return Vocabulary(**facts, items=thing.content["items"])


def _about(thing: StoredThing) -> dict[str, object]:
    return {name: getattr(thing, name) for name in ("project", "name", "version", "author", "changed")}
