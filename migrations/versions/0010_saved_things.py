"""What projects keep beside documents: queries, collections of documents, colours of motion names."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0010'
down_revision = '0009'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'saved',
        sa.Column('project', KEY, nullable=False),
        sa.Column('kind', sa.String(length=16), nullable=False),
        sa.Column('name', NAME, nullable=False),
        sa.Column('version', sa.Integer(), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('changed', sa.String(length=32), nullable=False),
        sa.Column('content', sa.Text(), nullable=False),
        sa.Column('checksum', sa.BigInteger(), nullable=True),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_saved_project')),
        sa.PrimaryKeyConstraint('project', 'kind', 'name', name=op.f('pk_saved')),
    )
