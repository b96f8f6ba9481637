"""The characters of the library: documents whose kept file has a mesh with a skin."""

from __future__ import annotations

import io
from collections.abc import Sequence
from contextlib import suppress

from mcml.errors import ConflictError, StoreError
from mcml.formats import READERS
from mcml.formats.format import CharacterReader
from mcml_schemas.skeletons import CharacterInfo, CharacterList
from mcml_service.storage.database import Database
from mcml_service.storage.documents.uploads import StoredCharacter
from mcml_service.storage.transaction import Transaction

_KINDS = tuple(name for name, reader in READERS.items() if isinstance(reader, CharacterReader))
MOST_BYTES, MOST_FILES = 64 << 20, 16
"""Of files of earlier programs that are looked into for one answer."""


def list_characters(tx: Transaction, project: int | None) -> tuple[CharacterList, list[tuple[int, int]]]:
    """List the characters, each file once, by name; and the vertices of files that were looked into for the first time,
    by their keys, to be kept."""
    files: dict[int, StoredCharacter] = {}
    found = tx.uploads.characters(_KINDS)
    listed = {one.key: one for one in tx.columns.documents([each.document for each in found])}
    for each in found:
        one = listed.get(each.document)
        if one is None or each.upload in files or project not in (None, one.project):
            continue
        # Of those alone that the user may see.
        if tx.documents.find(one.uuid) is not None:
            files[each.upload] = each
    unread = [each for each in files.values() if each.vertices is None]
    looked = {each.upload: _count(tx, each) for each in _choose(unread)}
    items = []
    for each in files.values():
        vertices = looked.get(each.upload) if each.vertices is None else each.vertices
        if vertices:
            seen = listed[each.document]
            name = tx.projects.name(seen.project)
            items.append(CharacterInfo(document=seen.uuid, name=seen.name, project=name, vertices=vertices))
    items.sort(key=lambda item: (item.name, item.document))
    return CharacterList(items=items, unread=len(unread) - len(looked)), list(looked.items())


def keep_vertices(database: Database, looked: Sequence[tuple[int, int]]) -> None:
    """Keep how many vertices files have. Where that cannot be now, they are counted again."""
    if not looked:
        return
    with suppress(StoreError, ConflictError), database.write() as tx:
        for key, vertices in looked:
            tx.uploads.set_vertices(key, vertices)


def _choose(unread: Sequence[StoredCharacter]) -> list[StoredCharacter]:
    """The files to look into for one answer."""
    chosen, room = [], MOST_BYTES
    for each in unread[:MOST_FILES]:
        if each.size > room:
            break
        room -= each.size
        chosen.append(each)
    return chosen


def _count(tx: Transaction, file: StoredCharacter) -> int:
    reader = READERS[file.part.partition("#")[0]]
    assert isinstance(reader, CharacterReader)
    return reader.count_vertices(io.BytesIO(b"".join(tx.uploads.blocks(file.upload))))
