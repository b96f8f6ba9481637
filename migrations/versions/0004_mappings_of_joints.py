"""Mappings of joints that a project keeps under names."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0004'
down_revision = '0003'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'joint_mapping',
        sa.Column('id', KEY, nullable=False),
        sa.Column('project', KEY, nullable=False),
        sa.Column('name', NAME, nullable=False),
        sa.Column('version', sa.Integer(), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('changed', sa.String(length=32), nullable=False),
        sa.Column('pairs', sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_joint_mapping_project')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_joint_mapping')),
        sa.UniqueConstraint('project', 'name', name=op.f('uq_joint_mapping_project_name')),
    )
