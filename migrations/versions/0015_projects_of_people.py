"""Roles of people in projects, and the projects of tokens and invitations."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0015'
down_revision = '0014'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'membership',
        sa.Column('account', KEY, nullable=False),
        sa.Column('project', KEY, nullable=False),
        sa.Column('role', sa.String(length=16), nullable=False),
        sa.ForeignKeyConstraint(['account'], ['account.id'], name=op.f('fk_membership_account')),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_membership_project')),
        sa.PrimaryKeyConstraint('account', 'project', name=op.f('pk_membership')),
    )
    op.create_table(
        'token_project',
        sa.Column('token', KEY, nullable=False),
        sa.Column('project', KEY, nullable=False),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_token_project_project')),
        sa.ForeignKeyConstraint(['token'], ['token.id'], name=op.f('fk_token_project_token')),
        sa.PrimaryKeyConstraint('token', 'project', name=op.f('pk_token_project')),
    )
    # Those that are open end within hours or days by themselves; who needs one is invited again.
    op.drop_table('invitation')
    op.create_table(
        'invitation',
        sa.Column('id', KEY, nullable=False),
        sa.Column('sha256', sa.String(length=64), nullable=False),
        sa.Column('role', sa.String(length=16), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('expires', sa.String(length=32), nullable=False),
        sa.Column('project', KEY, nullable=True),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_invitation_project')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_invitation')),
        sa.UniqueConstraint('sha256', name=op.f('uq_invitation_sha256')),
    )
