"""Webhooks, and the messages that were sent there."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0017'
down_revision = '0016'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'webhook',
        sa.Column('id', KEY, nullable=False),
        sa.Column('project', KEY, nullable=True),
        sa.Column('url', sa.Text(), nullable=False),
        sa.Column('kinds', sa.String(length=256), nullable=False),
        sa.Column('secret', sa.String(length=128), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('after', sa.BigInteger(), nullable=False),
        sa.Column('ended', sa.String(length=32), nullable=True),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_webhook_project')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_webhook')),
    )
    op.create_table(
        'webhook_delivery',
        sa.Column('id', KEY, nullable=False),
        sa.Column('webhook', KEY, nullable=False),
        sa.Column('message', sa.String(length=64), nullable=False),
        sa.Column('type', sa.String(length=64), nullable=False),
        sa.Column('payload', sa.Text(), nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('state', sa.String(length=16), nullable=False),
        sa.Column('attempts', sa.Integer(), nullable=False),
        sa.Column('due', sa.Float(precision=53), nullable=False),
        sa.Column('status', sa.Integer(), nullable=True),
        sa.Column('problem', sa.String(length=256), nullable=True),
        sa.ForeignKeyConstraint(['webhook'], ['webhook.id'], name=op.f('fk_webhook_delivery_webhook')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_webhook_delivery')),
    )
    op.create_index(op.f('ix_webhook_delivery_webhook'), 'webhook_delivery', ['webhook'], unique=False)
    op.create_index(op.f('ix_webhook_delivery_state_due'), 'webhook_delivery', ['state', 'due'], unique=False)
