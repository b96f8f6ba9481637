"""The store works, and the database does it in its own way."""

from pathlib import Path

import mcml
from mcml_service.storage.core.dialects.sqlite import SQLite
from mcml_service.storage.database import Database
from tests.builders import bvh

Path("walk.bvh").write_bytes(bvh(3))
with mcml.open("store.db") as store:
    store.import_("walk.bvh")
    assert [len(clip) for clip in store.documents()] == [3]
with Database("sqlite:///store.db").look() as tx:
    assert tx.newest_commit() > 0
assert SQLite.looks == 1
