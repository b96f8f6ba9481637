"""Long lists find their first page, their count, and what changed since, without reading all."""

from __future__ import annotations

from alembic import op

revision = '0012'
down_revision = '0011'
branch_labels = None
depends_on = None

THERE = ['name', 'state', 'deleted_commit', 'created_commit']


def upgrade() -> None:
    op.create_index(op.f('ix_revision_commit'), 'revision', ['commit'], unique=False)
    op.create_index('ix_document_there', 'document', THERE, unique=False)
