"""Proposed changes of documents, comments on them, and projects in which changes need a review."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0021'
down_revision = '0020'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'proposal',
        sa.Column('document', KEY, nullable=False),
        sa.Column('number', sa.Integer(), nullable=False),
        sa.Column('revision', sa.Integer(), nullable=False),
        sa.Column('kind', sa.String(length=16), nullable=False),
        sa.Column('content', sa.Text(), nullable=False),
        sa.Column('inputs', sa.Text(), nullable=False),
        sa.Column('summary', sa.Text(), nullable=False),
        sa.Column('message', sa.Text(), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('state', sa.String(length=16), nullable=False),
        sa.Column('reviewer', NAME, nullable=True),
        sa.Column('reviewed', sa.String(length=32), nullable=True),
        sa.Column('closer', NAME, nullable=True),
        sa.Column('closed', sa.String(length=32), nullable=True),
        sa.Column('applied', sa.Integer(), nullable=True),
        sa.Column('checksum', sa.BigInteger(), nullable=True),
        sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_proposal_document')),
        sa.PrimaryKeyConstraint('document', 'number', name=op.f('pk_proposal')),
    )
    op.add_column('comment', sa.Column('proposal', sa.Integer(), nullable=True))
    op.add_column('project_terms', sa.Column('review_required', sa.Boolean(), nullable=True))
