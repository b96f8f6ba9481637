"""Bodies in space: where joints are, and what is known of a clip, by the revision that they are of."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0013'
down_revision = '0012'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')


def upgrade() -> None:
    op.create_table(
        'body',
        sa.Column('document', KEY, nullable=False),
        sa.Column('revision', sa.Integer(), nullable=False),
        sa.Column('block', sa.Integer(), nullable=False),
        sa.Column('facts', sa.Text(), nullable=False),
        sa.Column('data', sa.LargeBinary(), nullable=False),
        sa.Column('checksum', sa.BigInteger(), nullable=True),
        sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_body_document')),
        sa.PrimaryKeyConstraint('document', 'revision', 'block', name=op.f('pk_body')),
    )
