"""Thumbnails of documents: small moving pictures, by the revision that they show."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0009'
down_revision = '0008'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')


def upgrade() -> None:
    op.create_table(
        'thumbnail',
        sa.Column('document', KEY, nullable=False),
        sa.Column('revision', sa.Integer(), nullable=False),
        sa.Column('facts', sa.Text(), nullable=False),
        sa.Column('data', sa.LargeBinary(), nullable=False),
        sa.Column('checksum', sa.BigInteger(), nullable=True),
        sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_thumbnail_document')),
        sa.PrimaryKeyConstraint('document', 'revision', name=op.f('pk_thumbnail')),
    )
