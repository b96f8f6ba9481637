"""Accounts of people and invitations; what tokens may do, whose they are, and when they were used."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0014'
down_revision = '0013'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'account',
        sa.Column('id', KEY, nullable=False),
        sa.Column('name', NAME, nullable=False),
        sa.Column('role', sa.String(length=16), nullable=False),
        sa.Column('password', sa.Text(), nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('closed', sa.String(length=32), nullable=True),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_account')),
        sa.UniqueConstraint('name', name=op.f('uq_account_name')),
    )
    op.create_table(
        'invitation',
        sa.Column('id', KEY, nullable=False),
        sa.Column('sha256', sa.String(length=64), nullable=False),
        sa.Column('role', sa.String(length=16), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('expires', sa.String(length=32), nullable=False),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_invitation')),
        sa.UniqueConstraint('sha256', name=op.f('uq_invitation_sha256')),
    )
    op.create_table(
        'token_grant',
        sa.Column('token', KEY, nullable=False),
        sa.Column('scope', sa.String(length=16), nullable=False),
        sa.Column('account', KEY, nullable=True),
        sa.Column('used', sa.String(length=32), nullable=True),
        sa.ForeignKeyConstraint(['account'], ['account.id'], name=op.f('fk_token_grant_account')),
        sa.ForeignKeyConstraint(['token'], ['token.id'], name=op.f('fk_token_grant_token')),
        sa.PrimaryKeyConstraint('token', name=op.f('pk_token_grant')),
    )
    # Tokens of before open everything, as they did.
    op.execute("INSERT INTO token_grant (token, scope) SELECT id, 'operate' FROM token")
    # Sessions end within hours by themselves.
    op.drop_table('session')
    op.create_table(
        'session',
        sa.Column('id', KEY, nullable=False),
        sa.Column('sha256', sa.String(length=64), nullable=False),
        sa.Column('kind', sa.String(length=16), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('token', KEY, nullable=True),
        sa.Column('account', KEY, nullable=True),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('expires', sa.String(length=32), nullable=False),
        sa.ForeignKeyConstraint(['account'], ['account.id'], name=op.f('fk_session_account')),
        sa.ForeignKeyConstraint(['token'], ['token.id'], name=op.f('fk_session_token')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_session')),
        sa.UniqueConstraint('sha256', name=op.f('uq_session_sha256')),
    )
