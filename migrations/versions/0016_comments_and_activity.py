"""Comments on documents, and events: what was done, by whom."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0016'
down_revision = '0015'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'comment',
        sa.Column('id', KEY, nullable=False),
        sa.Column('document', KEY, nullable=False),
        sa.Column('revision', sa.Integer(), nullable=False),
        sa.Column('first', sa.BigInteger(), nullable=True),
        sa.Column('last', sa.BigInteger(), nullable=True),
        sa.Column('bone', NAME, nullable=True),
        sa.Column('author', NAME, nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('text', sa.Text(), nullable=False),
        sa.Column('edited', sa.String(length=32), nullable=True),
        sa.Column('resolved', sa.String(length=32), nullable=True),
        sa.Column('deleted', sa.String(length=32), nullable=True),
        sa.Column('checksum', sa.BigInteger(), nullable=True),
        sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_comment_document')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_comment')),
    )
    op.create_index(op.f('ix_comment_document'), 'comment', ['document'], unique=False)
    op.create_table(
        'event',
        sa.Column('id', KEY, nullable=False),
        sa.Column('time', sa.String(length=32), nullable=False),
        sa.Column('kind', sa.String(length=16), nullable=False),
        sa.Column('what', sa.String(length=32), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('origin', sa.String(length=64), nullable=False),
        sa.Column('project', KEY, nullable=True),
        sa.Column('about', sa.String(length=36), nullable=True),
        sa.Column('revision', sa.Integer(), nullable=True),
        sa.Column('subject', NAME, nullable=False),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_event_project')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_event')),
    )
    op.create_index(op.f('ix_event_about'), 'event', ['about'], unique=False)
