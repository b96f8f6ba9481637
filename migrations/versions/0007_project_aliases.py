"""Names of joints that a project adds to those that are known."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0007'
down_revision = '0006'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'joint_alias',
        sa.Column('project', KEY, nullable=False),
        sa.Column('version', sa.Integer(), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('changed', sa.String(length=32), nullable=False),
        sa.Column('pairs', sa.Text(), nullable=False),
        sa.Column('checksum', sa.BigInteger(), nullable=True),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_joint_alias_project')),
        sa.PrimaryKeyConstraint('project', name=op.f('pk_joint_alias')),
    )
