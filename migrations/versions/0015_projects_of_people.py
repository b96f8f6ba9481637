"""Roles of people in projects, the projects of tokens and invitations, links to some documents, and sign-ins with
a provider; archives and quotas."""

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
    op.create_table(
        'share',
        sa.Column('id', KEY, nullable=False),
        sa.Column('sha256', sa.String(length=64), nullable=False),
        sa.Column('name', NAME, nullable=False),
        sa.Column('project', KEY, nullable=False),
        sa.Column('formats', sa.String(length=256), nullable=False),
        sa.Column('author', NAME, nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('expires', sa.String(length=32), nullable=False),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_share_project')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_share')),
        sa.UniqueConstraint('sha256', name=op.f('uq_share_sha256')),
    )
    op.create_table(
        'shared_document',
        sa.Column('share', KEY, nullable=False),
        sa.Column('document', KEY, nullable=False),
        sa.Column('revision', sa.Integer(), nullable=False),
        sa.Column('latest', sa.Boolean(), nullable=False),
        sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_shared_document_document')),
        sa.ForeignKeyConstraint(['share'], ['share.id'], name=op.f('fk_shared_document_share')),
        sa.PrimaryKeyConstraint('share', 'document', name=op.f('pk_shared_document')),
    )
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
        sa.Column('share', KEY, nullable=True),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('expires', sa.String(length=32), nullable=False),
        sa.ForeignKeyConstraint(['account'], ['account.id'], name=op.f('fk_session_account')),
        sa.ForeignKeyConstraint(['share'], ['share.id'], name=op.f('fk_session_share')),
        sa.ForeignKeyConstraint(['token'], ['token.id'], name=op.f('fk_session_token')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_session')),
        sa.UniqueConstraint('sha256', name=op.f('uq_session_sha256')),
    )
    op.create_table(
        'identity',
        sa.Column('issuer', sa.String(length=512), nullable=False),
        sa.Column('subject', sa.String(length=255), nullable=False),
        sa.Column('account', KEY, nullable=False),
        sa.ForeignKeyConstraint(['account'], ['account.id'], name=op.f('fk_identity_account')),
        sa.PrimaryKeyConstraint('issuer', 'subject', name=op.f('pk_identity')),
    )
    op.create_table(
        'project_terms',
        sa.Column('project', KEY, nullable=False),
        sa.Column('archived', sa.String(length=32), nullable=True),
        sa.Column('most_documents', sa.BigInteger(), nullable=True),
        sa.Column('most_bytes', sa.BigInteger(), nullable=True),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_project_terms_project')),
        sa.PrimaryKeyConstraint('project', name=op.f('pk_project_terms')),
    )
