"""Attempts to log in, counted for all servers of a store."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0018'
down_revision = '0017'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')


def upgrade() -> None:
    op.create_table(
        'attempt',
        sa.Column('id', KEY, nullable=False),
        sa.Column('sha256', sa.String(length=64), nullable=False),
        sa.Column('expires', sa.Float(precision=53), nullable=False),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_attempt')),
    )
    op.create_index(op.f('ix_attempt_sha256_expires'), 'attempt', ['sha256', 'expires'], unique=False)
