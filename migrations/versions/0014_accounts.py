"""Accounts of people and invitations; what tokens may do, whose they are, and when they were used."""

from __future__ import annotations

import orjson
import sqlalchemy as sa
from alembic import op
from xxhash import xxh3_64_intdigest

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
    with op.batch_alter_table('token') as batch:
        # Tokens of before open everything, as they did.
        batch.add_column(sa.Column('scope', sa.String(length=16), nullable=False, server_default='operate'))
        batch.add_column(sa.Column('account', KEY, nullable=True))
        batch.add_column(sa.Column('used', sa.String(length=32), nullable=True))
        batch.create_foreign_key(op.f('fk_token_account'), 'account', ['account'], ['id'])
    with op.batch_alter_table('token') as batch:
        batch.alter_column('scope', server_default=None)
    with op.batch_alter_table('session') as batch:
        batch.add_column(sa.Column('account', KEY, nullable=True))
        batch.create_foreign_key(op.f('fk_session_account'), 'account', ['account'], ['id'])
    connection = op.get_bind()
    token = sa.table('token', *map(sa.column, ('id', 'name', 'sha256', 'hint', 'created', 'expires', 'checksum')))
    for key, *values, checksum in connection.execute(sa.select(token)).all():
        if checksum is not None:
            made = xxh3_64_intdigest(orjson.dumps((*values, 'operate', None))) >> 12
            connection.execute(sa.update(token).where(token.c.id == key).values(checksum=made))
