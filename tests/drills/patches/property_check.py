"""The property is kept a revision, shown, and taken back."""

from pathlib import Path

import mcml
from mcml_service.storage.database import Database
from tests.builders import bvh

Path("walk.bvh").write_bytes(bvh(3))
with mcml.open("store.db") as store:
    store.import_("walk.bvh")
    (walk,) = store.documents()
database = Database("sqlite:///store.db")
with database.write("kim") as tx:
    tx.documents.write_content(tx.documents.get(walk.id).key, tx.commit, captured="2026-11-26")
    tx.documents.add_revision(tx.documents.get(walk.id), "change")
with mcml.open("store.db") as store:
    (shown,) = store.operations.list_documents().items
    assert shown.captured == "2026-11-26"
    store.operations.undo_revision(id=walk.id, if_match="*")
    assert store.operations.get_document(id=walk.id).captured is None
