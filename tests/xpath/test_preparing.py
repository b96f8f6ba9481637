"""Columns that a server builds before the first query: what is built, what is not, and how the work is interrupted."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from mcml_schemas.querying.queries import QueryRequest
from mcml_service.clips.bodies import MADE
from mcml_service.clips.derive import derive_missing
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath import column_builder
from mcml_service.xpath.column_builder import build_columns, build_stage
from mcml_service.xpath.library import groups, preparing
from mcml_service.xpath.library.disk.part_file import path_of
from mcml_service.xpath.library.forest import name_samples
from mcml_service.xpath.library.preparing import DAY, LATELY, count_prepared, wanted_columns, wanted_quantities
from mcml_service.xpath.queries import Queries
from tests.xpath.test_sidecar import answers, asking, copy_store, expected, filled, no_reading, rows


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Database]:
    monkeypatch.setattr(groups, "DOCUMENTS", 12)
    monkeypatch.setattr(groups, "MOST_DOCUMENTS", 30)
    monkeypatch.setattr(groups, "LASTING", 1)
    monkeypatch.setattr(preparing, "COMMON_BONES", ("Root", "left_up_leg"))
    database = copy_store(tmp_path / "store.db")
    yield database
    database.close()


def build(database: Database, stages: tuple[column_builder.Stage, ...] = ("columns", "bodies")) -> tuple[int, int]:
    with asking(database) as engine:
        for stage in stages:
            build_stage(engine, stage)
        return count_prepared(database, engine.caches)


def parts(database: Database) -> list[tuple[bytes, str]]:
    path = path_of(database, "")
    assert path is not None
    return rows(path)


@pytest.mark.slow
def test_first_queries_read_no_columns_of_the_store(library: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = expected(library)
    built, of = build(library)
    assert built == of > 2
    no_reading(library, monkeypatch)
    with asking(library) as engine:
        assert answers(engine) == wanted


def test_what_is_built_already_is_not_built_again(library: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    build(library)
    before = parts(library)
    monkeypatch.setattr("mcml_service.xpath.library.disk.sidecar.Sidecar.keep", lambda *_: pytest.fail("built again"))
    build(library)
    assert parts(library) == before


def test_the_work_goes_on_where_it_was_interrupted(library: Database) -> None:
    build(library)
    whole = parts(library)
    Path(f"{path_of(library, '')}").unlink()
    steps: list[int] = []

    def progress(done: int, of: int) -> None:
        steps.append(done)
        if len(steps) == of // 2 + 1:
            raise KeyboardInterrupt

    with asking(library) as engine, pytest.raises(KeyboardInterrupt):
        build_stage(engine, "columns", progress)
    half = parts(library)
    assert 0 < len(half) < len(whole)
    build(library)
    assert parts(library) == whole


@pytest.mark.slow
def test_columns_asked_for_lately_are_built_for_new_documents(library: Database) -> None:
    asked = name_samples(("left_low_leg", 4))
    build(library)
    assert asked not in {name for _, name in parts(library)}
    with asking(library) as engine:
        engine.answer(QueryRequest(q="count(//frame_bone[@name='left_low_leg'][@Ry > 0])"))
    before = {held for held, name in parts(library) if name == asked}
    filled(Path(f"{library.dialect.file}"), first=40).close()
    build(library)
    assert before
    assert {held for held, name in parts(library) if name == asked} - before


def test_a_column_that_is_built_counts_as_not_asked_for(library: Database) -> None:
    build(library)
    with asking(library) as engine:
        assert engine.caches.sidecar is not None
        uses = engine.caches.sidecar.last_uses()
    samples = {name: used for name, used in uses.items() if name.startswith("samples")}
    assert samples
    assert set(samples.values()) == {0}


def test_the_newest_columns_come_first_and_old_ones_are_left_out() -> None:
    now = time.time()
    uses = {
        name_samples(("a", 3)): int(now - LATELY - 1),
        name_samples(("b", 3)): int(now - 2 * DAY),
        name_samples(("c", 4)): int(now - DAY),
        name_samples((None, 4)): int(now),
        "shapes": int(now),
    }
    columns = wanted_columns(uses, now)
    assert columns[:2] == [("c", 4), ("b", 3)]
    assert ("a", 3) not in columns
    assert ("Root", 0) in columns
    assert len(columns) == len(set(columns))
    quantities = wanted_quantities(
        {f'bodies ["{MADE}","speed","left_hand"]': int(now), 'bodies ["1","height","x"]': 1}, now
    )
    assert ("speed", "left_hand") in quantities
    assert ("height", "x") not in quantities


def test_a_full_file_ends_the_work(library: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mcml_service.xpath.library.disk.sidecar.Sidecar.room", lambda _: 0)
    built, of = build(library, ("columns",))
    assert built == 0 < of


def test_a_process_builds_the_columns_of_a_store(library: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    derive_missing(library, lambda *_: None)
    # The process has groups as they are, of which so few documents are none.
    monkeypatch.undo()
    settings = Settings(cache_dir=f"{Path(f'{library.dialect.file}').parent}/kept")
    build_columns(library, settings, "columns", lambda: True)
    build_columns(library, settings, "bodies", lambda: True)
    path = path_of(library, settings.cache_dir)
    assert path is not None
    names = {name for _, name in rows(path)}
    assert names.issuperset(preparing.BASE)
    assert any(name.startswith("poses") for name in names)


def test_a_process_ends_when_the_server_stops(library: Database) -> None:
    build_columns(library, Settings(), "columns", lambda: False)
    path = path_of(library, "")
    assert path is not None
    assert not path.exists() or not rows(path)


def test_no_columns_are_built_where_none_are_kept(library: Database) -> None:
    build_columns(library, Settings(cache_dir="none"), "columns", lambda: pytest.fail("asked whether to go on"))
    with closing(Queries(library, Settings(cache_dir="none"))) as engine:
        build_stage(engine, "columns")
        assert count_prepared(library, engine.caches)[0] == 0
