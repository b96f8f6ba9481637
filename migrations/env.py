"""Runs migrations on the connection that whoever calls alembic hands over in `attributes` of its configuration.

metadata: there where a migration is made of the difference between tables and a store (`make migration`). Neither this
file nor a migration imports anything of the program: what they do stays as it was on the day they were written.
"""

from __future__ import annotations

from alembic import context

_given = context.config.attributes
context.configure(connection=_given["connection"], target_metadata=_given.get("metadata"), render_as_batch=False)
context.run_migrations()
