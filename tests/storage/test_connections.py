"""Databases with no connection to give: those who ask are told to come again, and then are answered."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from sqlalchemy import create_engine, make_url, text

from mcml.errors import UnavailableError
from mcml_service.storage.core.dialects import postgresql
from mcml_service.storage.database import Database
from tests import postgres


@pytest.fixture
def guest(postgres_template: str) -> Iterator[Database]:
    """A store in PostgreSQL, asked by someone who may have one connection."""
    with postgres.new_database(postgres_template, "template_store") as url:
        role = make_url(url).database
        owner = create_engine(url, isolation_level="AUTOCOMMIT")
        with owner.connect() as connection:
            connection.execute(text(f"CREATE ROLE {role} LOGIN CONNECTION LIMIT 1"))
            connection.execute(text(f"GRANT ALL ON ALL TABLES IN SCHEMA public TO {role}"))
        owner.dispose()
        database = Database(make_url(url).set(username=role).render_as_string(hide_password=False))
        yield database
        database.close()
        owner = create_engine(url, isolation_level="AUTOCOMMIT")
        with owner.connect() as connection:
            connection.execute(text(f"DROP OWNED BY {role}"))
            connection.execute(text(f"DROP ROLE {role}"))
        owner.dispose()


def test_who_gets_no_connection_is_told_to_come_again(guest: Database) -> None:
    for _ in range(2):
        with guest.read() as tx:
            assert tx.projects.find("lab") is None
            with pytest.raises(UnavailableError, match="cannot be reached now"), guest.read():
                pass
    with guest.read() as tx:
        assert tx.projects.find("lab") is None


def test_connections_that_ended_while_they_rested_are_not_used(
    postgres_template: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The server ends them, and nobody hears of it until he asks."""
    with postgres.new_database(postgres_template, "template_store") as url:
        database = Database(url)
        with database.read() as one, database.read() as other:
            assert one.projects.find("lab") is other.projects.find("lab") is None
        _end_all(url)
        # Where it was used just now, nobody looks.
        monkeypatch.setattr(postgresql, "REST_SECONDS", 3600.0)
        with pytest.raises(UnavailableError), database.read() as tx:
            tx.projects.find("lab")
        with database.read() as one, database.read() as other:
            assert one.projects.find("lab") is other.projects.find("lab") is None
        _end_all(url)
        monkeypatch.setattr(postgresql, "REST_SECONDS", 0.0)
        with database.read() as tx:
            assert tx.projects.find("lab") is None
        database.close()


def _end_all(url: str) -> None:
    owner = create_engine(url, isolation_level="AUTOCOMMIT")
    with owner.connect() as connection:
        others = "SELECT pg_terminate_backend(pid, 5000) FROM pg_stat_activity "
        its = "WHERE datname = current_database() AND pid <> pg_backend_pid()"
        assert connection.execute(text(others + its)).scalars().all() == [True, True]
    owner.dispose()


def test_who_waits_too_long_for_a_place_is_told(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    pool = database.dialect.engine.pool
    for name, value in (("_timeout", 0.01), ("_max_overflow", 0)):
        monkeypatch.setattr(pool, name, value)
    held = [database.dialect.engine.connect() for _ in range(16)]
    with pytest.raises(UnavailableError, match="All connections"), database.read():
        pass
    held.pop().close()
    with database.read() as tx:
        assert tx.projects.find("lab") is None
    for one in held:
        one.close()
