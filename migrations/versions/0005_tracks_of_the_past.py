"""Tracks of the past are found by the commit that closed them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0005'
down_revision = '0004'
branch_labels = None
depends_on = None

CLOSED = sa.text('to_commit < 9223372036854775807')


def upgrade() -> None:
    op.create_index(
        'ix_track_closed', 'track', ['document', 'to_commit'], sqlite_where=CLOSED, postgresql_where=CLOSED
    )
