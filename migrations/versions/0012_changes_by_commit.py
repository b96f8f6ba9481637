"""Revisions are found by their commit: what changed since is asked often."""

from __future__ import annotations

from alembic import op

revision = '0012'
down_revision = '0011'
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_index(op.f('ix_revision_commit'), 'revision', ['commit'], unique=False)
