"""Kill the importer anywhere: the document is whole or absent, and the store is sound."""

from __future__ import annotations

import random
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from sqlalchemy import func, select

from mcml_service.actions.exporting.export_motion import ExportOptions, export_document
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.core.tables import document
from mcml_service.storage.database import Database
from mcml_service.storage.lists.filtering import DocumentFilter
from tests.builders import bvh, store

IMPORTER = textwrap.dedent(
    """
    import os, pathlib, signal, sys
    sys.path.insert(0, {root!r})
    from sqlalchemy import event
    from mcml_service.actions.importing import import_clip, keep_upload
    from mcml_service.storage.database import Database
    from tests.builders import store

    import_clip.FLUSH_BYTES = 30_000
    keep_upload.EARLY_BYTES = 0
    database = Database(sys.argv[1])
    fatal, seen = int(sys.argv[3]), 0

    def step(*_):
        global seen
        seen += 1
        if seen == fatal:
            os.kill(os.getpid(), signal.SIGKILL)

    for moment in ("before_cursor_execute", "after_cursor_execute", "commit"):
        event.listen(database.dialect.engine, moment, step)
    given = pathlib.Path(sys.argv[2])
    files = sorted(given.iterdir()) if given.is_dir() else [given]
    store(database, {{path.name: path.read_bytes() for path in files}}, labels=())
    print(seen)
    """
)


def run(url: str, path: Path, fatal: int) -> subprocess.CompletedProcess[str]:
    program = IMPORTER.format(root=str(Path(__file__).resolve().parents[2]))
    return subprocess.run([sys.executable, "-c", program, url, str(path), str(fatal)], capture_output=True, text=True)


def killed_at_seeded_points(database: Database, url: str, folder: Path, times: int, seed: int) -> None:
    content = bvh(3000, seed=seed, names=("Hips", "Spine", "Spine1", "Neck", "Head"))
    path = folder / "long.bvh"
    path.write_bytes(content)
    rehearsal = Database(f"sqlite:///{folder / 'rehearsal.db'}")
    rehearsal.migrate()
    done = run(f"sqlite:///{folder / 'rehearsal.db'}", path, 0)
    assert done.returncode == 0, done.stderr
    steps = int(done.stdout)
    assert steps > 40
    chance = random.Random(seed)
    points = sorted(chance.sample(range(1, steps + 1), min(times, steps)))
    whole = 0
    for point in points:
        outcome = run(url, path, point)
        assert outcome.returncode in (-9, 0), outcome.stderr
        with database.read() as tx:
            found = tx.documents.page(DocumentFilter(), after=None, limit=1000)
            assert len(found) in (whole, whole + 1)
            if len(found) == whole + 1:
                whole += 1
                for original in (True, False):
                    export = export_document(tx, found[-1], ExportOptions("bvh", original=original))
                    assert b"".join(export.content) == content
        assert database.check() == []
    database.sweep(lease_before=float("inf"))
    with database.read() as tx:
        keys = set(tx.connection.execute(select(document.c.id)).scalars())
        assert len(keys) == whole
        for table in metadata.sorted_tables:
            if "document" in table.c and table is not document:
                rows = tx.connection.execute(select(table.c.document).distinct()).scalars()
                assert set(rows) <= keys, table.name
        upload = metadata.tables["upload"]
        assert tx.connection.execute(select(func.count()).select_from(upload).where(~upload.c.complete)).scalar() == 0
    store(database, {"long.bvh": content})
    assert database.check() == []


@pytest.mark.slow
def test_killed_importer_leaves_all_or_nothing(database: Database, database_url: str, tmp_path: Path) -> None:
    killed_at_seeded_points(database, database_url, tmp_path, 2, seed=20)


@pytest.mark.fuzz(seeds=1)
@pytest.mark.timeout(1800)
def test_killed_importer_many_times(database: Database, database_url: str, tmp_path: Path, seed: int) -> None:
    killed_at_seeded_points(database, database_url, tmp_path, 50, seed)
