"""Runs migrations on the connection that `Database.migrate` hands over, or on `MCML_DATABASE` for `alembic` itself."""

from __future__ import annotations

from alembic import context

from mcml_service.storage import tables, visits, work_tables  # noqa: F401 - they add themselves to the metadata
from mcml_service.storage.schema import metadata

connection = context.config.attributes.get("connection")
if connection is None:
    from mcml_service.settings import Settings
    from mcml_service.storage.database import Database

    with Database(Settings().database_url).dialect.writing() as connection:
        context.configure(connection=connection, target_metadata=metadata, render_as_batch=False)
        with context.begin_transaction():
            context.run_migrations()
else:
    context.configure(connection=connection, target_metadata=metadata, render_as_batch=False)
    context.run_migrations()
