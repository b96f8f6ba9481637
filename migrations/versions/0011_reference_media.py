"""Video or audio that documents carry for reference."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0011'
down_revision = '0010'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'document_media',
        sa.Column('document', KEY, nullable=False),
        sa.Column('upload', KEY, nullable=False),
        sa.Column('file_name', NAME, nullable=False),
        sa.Column('media_type', sa.String(length=64), nullable=False),
        sa.Column('offset', sa.Float(precision=53), nullable=False),
        sa.Column('checksum', sa.BigInteger(), nullable=True),
        sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_document_media_document')),
        sa.ForeignKeyConstraint(['upload'], ['upload.id'], name=op.f('fk_document_media_upload')),
        sa.PrimaryKeyConstraint('document', name=op.f('pk_document_media')),
    )
    op.create_index(op.f('ix_document_media_upload'), 'document_media', ['upload'], unique=False)
