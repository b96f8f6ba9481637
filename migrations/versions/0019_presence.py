"""Who looks at which document now, or edits it."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0019'
down_revision = '0018'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')


def upgrade() -> None:
    op.create_table(
        'presence',
        sa.Column('id', KEY, nullable=False),
        sa.Column('document', KEY, nullable=False),
        sa.Column('account', KEY, nullable=False),
        sa.Column('tab', sa.String(length=36), nullable=False),
        sa.Column('doing', sa.String(length=16), nullable=False),
        sa.Column('since', sa.String(length=32), nullable=False),
        sa.Column('expires', sa.Float(precision=53), nullable=False),
        sa.ForeignKeyConstraint(['account'], ['account.id'], name=op.f('fk_presence_account')),
        sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_presence_document')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_presence')),
    )
    op.create_index(op.f('ix_presence_document'), 'presence', ['document'], unique=False)
