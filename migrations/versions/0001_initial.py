"""The first schema: documents as elements, runs and tracks, with their revisions and kept uploads."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0001'
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    
    op.create_table('commit',
    sa.Column('number', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('time', sa.String(length=32), nullable=False),
    sa.Column('author', sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql'), nullable=False),
    sa.PrimaryKeyConstraint('number', name=op.f('pk_commit'))
    )
    op.create_table('project',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('name', sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql'), nullable=False),
    sa.Column('created', sa.String(length=32), nullable=False),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_project')),
    sa.UniqueConstraint('name', name=op.f('uq_project_name'))
    )
    op.create_table('token',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('name', sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql'), nullable=False),
    sa.Column('sha256', sa.String(length=64), nullable=False),
    sa.Column('hint', sa.String(length=16), nullable=False),
    sa.Column('created', sa.String(length=32), nullable=False),
    sa.Column('expires', sa.String(length=32), nullable=True),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_token')),
    sa.UniqueConstraint('name', name=op.f('uq_token_name')),
    sa.UniqueConstraint('sha256', name=op.f('uq_token_sha256'))
    )
    op.create_table('upload',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('sha256', sa.String(length=64), nullable=False),
    sa.Column('size', sa.BigInteger(), nullable=False),
    sa.Column('complete', sa.Boolean(), nullable=False),
    sa.Column('lease', sa.Float(), nullable=True),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_upload'))
    )
    op.create_index(op.f('ix_upload_sha256'), 'upload', ['sha256'], unique=False)
    op.create_table('document',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('uuid', sa.String(length=36), nullable=False),
    sa.Column('project', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('state', sa.String(length=16), nullable=False),
    sa.Column('lease', sa.Float(), nullable=True),
    sa.Column('name', sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql'), nullable=False),
    sa.Column('format', sa.String(length=32), nullable=False),
    sa.Column('created_commit', sa.BigInteger(), nullable=True),
    sa.Column('deleted_commit', sa.BigInteger(), nullable=False),
    sa.Column('next_slot', sa.BigInteger(), nullable=False),
    sa.Column('receipt', sa.LargeBinary(), nullable=False),
    sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_document_project')),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_document')),
    sa.UniqueConstraint('uuid', name=op.f('uq_document_uuid'))
    )
    op.create_index(op.f('ix_document_project_name'), 'document', ['project', 'name'], unique=False)
    op.create_table('skeleton',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('project', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('hash', sa.String(length=64), nullable=False),
    sa.Column('joints', sa.Integer(), nullable=False),
    sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_skeleton_project')),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_skeleton')),
    sa.UniqueConstraint('project', 'hash', name=op.f('uq_skeleton_project_hash'))
    )
    op.create_table('upload_block',
    sa.Column('upload', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('number', sa.Integer(), nullable=False),
    sa.Column('data', sa.LargeBinary(), nullable=False),
    sa.ForeignKeyConstraint(['upload'], ['upload.id'], name=op.f('fk_upload_block_upload')),
    sa.PrimaryKeyConstraint('upload', 'number', name=op.f('pk_upload_block'))
    )
    op.create_table('bone',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('bone', sa.Integer(), nullable=False),
    sa.Column('from_commit', sa.BigInteger(), nullable=False),
    sa.Column('to_commit', sa.BigInteger(), nullable=False),
    sa.Column('name', sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql'), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_bone_document')),
    sa.PrimaryKeyConstraint('document', 'bone', 'from_commit', name=op.f('pk_bone')),
    sqlite_with_rowid=False
    )
    op.create_index(op.f('ix_bone_name_document'), 'bone', ['name', 'document'], unique=False)
    op.create_table('content',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('from_commit', sa.BigInteger(), nullable=False),
    sa.Column('to_commit', sa.BigInteger(), nullable=False),
    sa.Column('skeleton', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('version', sa.String(length=32), nullable=False),
    sa.Column('frames', sa.BigInteger(), nullable=False),
    sa.Column('frame_time', sa.String(length=64), nullable=True),
    sa.Column('intact', sa.Boolean(), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_content_document')),
    sa.ForeignKeyConstraint(['skeleton'], ['skeleton.id'], name=op.f('fk_content_skeleton')),
    sa.PrimaryKeyConstraint('document', 'from_commit', name=op.f('pk_content')),
    sqlite_with_rowid=False
    )
    op.create_index(op.f('ix_content_skeleton'), 'content', ['skeleton'], unique=False)
    op.create_table('document_upload',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('part', sa.String(length=16), nullable=False),
    sa.Column('file_name', sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql'), nullable=False),
    sa.Column('upload', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_document_upload_document')),
    sa.ForeignKeyConstraint(['upload'], ['upload.id'], name=op.f('fk_document_upload_upload')),
    sa.PrimaryKeyConstraint('document', 'part', name=op.f('pk_document_upload')),
    sqlite_with_rowid=False
    )
    op.create_index(op.f('ix_document_upload_upload'), 'document_upload', ['upload'], unique=False)
    op.create_table('frame_run',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('first', sa.BigInteger(), nullable=False),
    sa.Column('from_commit', sa.BigInteger(), nullable=False),
    sa.Column('to_commit', sa.BigInteger(), nullable=False),
    sa.Column('count', sa.BigInteger(), nullable=False),
    sa.Column('first_id', sa.BigInteger(), nullable=True),
    sa.Column('step', sa.BigInteger(), nullable=True),
    sa.Column('texts', sa.Text(), nullable=True),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_frame_run_document')),
    sa.PrimaryKeyConstraint('document', 'first', 'from_commit', name=op.f('pk_frame_run')),
    sqlite_with_rowid=False
    )
    op.create_table('header',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('pre', sa.Integer(), nullable=False),
    sa.Column('from_commit', sa.BigInteger(), nullable=False),
    sa.Column('to_commit', sa.BigInteger(), nullable=False),
    sa.Column('size', sa.Integer(), nullable=False),
    sa.Column('level', sa.SmallInteger(), nullable=False),
    sa.Column('tag', sa.String(length=32), nullable=False),
    sa.Column('attributes', sa.Text(), nullable=False),
    sa.Column('text', sa.Text(), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_header_document')),
    sa.PrimaryKeyConstraint('document', 'pre', 'from_commit', name=op.f('pk_header')),
    sqlite_with_rowid=False
    )
    op.create_table('property',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('name', sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql'), nullable=False),
    sa.Column('number', sa.Float(), nullable=True),
    sa.Column('text', sa.Text(), nullable=False),
    sa.Column('unit', sa.String(length=64), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_property_document')),
    sa.PrimaryKeyConstraint('document', 'name', name=op.f('pk_property')),
    sqlite_with_rowid=False
    )
    op.create_index(op.f('ix_property_name_number'), 'property', ['name', 'number'], unique=False)
    op.create_table('revision',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('number', sa.Integer(), nullable=False),
    sa.Column('commit', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('parent', sa.Integer(), nullable=True),
    sa.Column('operation', sa.String(length=32), nullable=False),
    sa.Column('message', sa.Text(), nullable=False),
    sa.ForeignKeyConstraint(['commit'], ['commit.number'], name=op.f('fk_revision_commit')),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_revision_document')),
    sa.PrimaryKeyConstraint('document', 'number', name=op.f('pk_revision')),
    sqlite_with_rowid=False
    )
    op.create_table('shape',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('shape', sa.Integer(), nullable=False),
    sa.Column('bones', sa.LargeBinary(), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_shape_document')),
    sa.PrimaryKeyConstraint('document', 'shape', name=op.f('pk_shape')),
    sqlite_with_rowid=False
    )
    op.create_table('shape_run',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('slot', sa.BigInteger(), nullable=False),
    sa.Column('from_commit', sa.BigInteger(), nullable=False),
    sa.Column('to_commit', sa.BigInteger(), nullable=False),
    sa.Column('count', sa.BigInteger(), nullable=False),
    sa.Column('shape', sa.Integer(), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_shape_run_document')),
    sa.PrimaryKeyConstraint('document', 'slot', 'from_commit', name=op.f('pk_shape_run')),
    sqlite_with_rowid=False
    )
    op.create_table('skeleton_element',
    sa.Column('skeleton', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('pre', sa.Integer(), nullable=False),
    sa.Column('size', sa.Integer(), nullable=False),
    sa.Column('level', sa.SmallInteger(), nullable=False),
    sa.Column('tag', sa.String(length=32), nullable=False),
    sa.Column('attributes', sa.Text(), nullable=False),
    sa.Column('text', sa.Text(), nullable=False),
    sa.ForeignKeyConstraint(['skeleton'], ['skeleton.id'], name=op.f('fk_skeleton_element_skeleton')),
    sa.PrimaryKeyConstraint('skeleton', 'pre', name=op.f('pk_skeleton_element')),
    sqlite_with_rowid=False
    )
    op.create_table('span',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('from_commit', sa.BigInteger(), nullable=False),
    sa.Column('to_commit', sa.BigInteger(), nullable=False),
    sa.Column('name', sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql'), nullable=False),
    sa.Column('first', sa.BigInteger(), nullable=False),
    sa.Column('last', sa.BigInteger(), nullable=False),
    sa.Column('rank', sa.Integer(), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_span_document')),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_span'))
    )
    op.create_index(op.f('ix_span_document_first'), 'span', ['document', 'first'], unique=False)
    op.create_index(op.f('ix_span_name_document'), 'span', ['name', 'document'], unique=False)
    op.create_table('timeline',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('first', sa.BigInteger(), nullable=False),
    sa.Column('from_commit', sa.BigInteger(), nullable=False),
    sa.Column('to_commit', sa.BigInteger(), nullable=False),
    sa.Column('slot', sa.BigInteger(), nullable=False),
    sa.Column('count', sa.BigInteger(), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_timeline_document')),
    sa.PrimaryKeyConstraint('document', 'first', 'from_commit', name=op.f('pk_timeline')),
    sqlite_with_rowid=False
    )
    op.create_table('track',
    sa.Column('document', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('chunk', sa.Integer(), nullable=False),
    sa.Column('bone', sa.Integer(), nullable=False),
    sa.Column('from_commit', sa.BigInteger(), nullable=False),
    sa.Column('to_commit', sa.BigInteger(), nullable=False),
    sa.Column('count', sa.SmallInteger(), nullable=False),
    sa.Column('channels', sa.SmallInteger(), nullable=False),
    sa.Column('has_missing', sa.SmallInteger(), nullable=False),
    sa.Column('min_Tx', sa.Float(precision=53), nullable=True),
    sa.Column('max_Tx', sa.Float(precision=53), nullable=True),
    sa.Column('min_Ty', sa.Float(precision=53), nullable=True),
    sa.Column('max_Ty', sa.Float(precision=53), nullable=True),
    sa.Column('min_Tz', sa.Float(precision=53), nullable=True),
    sa.Column('max_Tz', sa.Float(precision=53), nullable=True),
    sa.Column('min_Rx', sa.Float(precision=53), nullable=True),
    sa.Column('max_Rx', sa.Float(precision=53), nullable=True),
    sa.Column('min_Ry', sa.Float(precision=53), nullable=True),
    sa.Column('max_Ry', sa.Float(precision=53), nullable=True),
    sa.Column('min_Rz', sa.Float(precision=53), nullable=True),
    sa.Column('max_Rz', sa.Float(precision=53), nullable=True),
    sa.Column('min_SF', sa.Float(precision=53), nullable=True),
    sa.Column('max_SF', sa.Float(precision=53), nullable=True),
    sa.Column('min_residual', sa.Float(precision=53), nullable=True),
    sa.Column('max_residual', sa.Float(precision=53), nullable=True),
    sa.Column('codec', sa.SmallInteger(), nullable=False),
    sa.Column('data', sa.LargeBinary(), nullable=False),
    sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_track_document')),
    sa.PrimaryKeyConstraint('document', 'chunk', 'bone', 'from_commit', name=op.f('pk_track'))
    )
    
