"""The store works, and the database does it in its own way."""

from pathlib import Path

import mcml
from mcml_service.storage.core.dialects.sqlite import SQLite
from tests.builders import bvh

Path("walk.bvh").write_bytes(bvh(3))
with mcml.open("store.db") as store:
    store.import_("walk.bvh")
    assert [len(one) for one in store.documents()] == [3]
assert SQLite.reads > 0
