"""Vertices of the skinned meshes in kept files: which documents are characters."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0022'
down_revision = '0021'
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column('upload', sa.Column('vertices', sa.Integer(), nullable=True))
