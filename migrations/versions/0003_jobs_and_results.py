"""Jobs, and the results that analyses leave."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0003'
down_revision = '0002'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.create_table(
        'result',
        sa.Column('id', KEY, nullable=False),
        sa.Column('uuid', sa.String(length=36), nullable=False),
        sa.Column('project', KEY, nullable=False),
        sa.Column('parent', KEY, nullable=True),
        sa.Column('analysis', sa.String(length=64), nullable=False),
        sa.Column('name', NAME, nullable=False),
        sa.Column('owner', NAME, nullable=False),
        sa.Column('inputs', sa.Text(), nullable=False),
        sa.Column('parameters', sa.Text(), nullable=False),
        sa.Column('made_with', sa.Text(), nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.ForeignKeyConstraint(['parent'], ['result.id'], name=op.f('fk_result_parent')),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_result_project')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_result')),
        sa.UniqueConstraint('uuid', name=op.f('uq_result_uuid')),
    )
    op.create_index(op.f('ix_result_project'), 'result', ['project'])
    op.create_index(op.f('ix_result_parent'), 'result', ['parent'])
    op.create_table(
        'job',
        sa.Column('id', KEY, nullable=False),
        sa.Column('uuid', sa.String(length=36), nullable=False),
        sa.Column('project', KEY, nullable=False),
        sa.Column('analysis', sa.String(length=64), nullable=False),
        sa.Column('name', NAME, nullable=False),
        sa.Column('owner', NAME, nullable=False),
        sa.Column('state', sa.String(length=16), nullable=False),
        sa.Column('inputs', sa.Text(), nullable=False),
        sa.Column('parameters', sa.Text(), nullable=False),
        sa.Column('stage', sa.String(length=256), nullable=False),
        sa.Column('share', sa.Float(), nullable=False),
        sa.Column('attempt', sa.Integer(), nullable=False),
        sa.Column('runner', sa.String(length=64), nullable=True),
        sa.Column('lease', sa.Float(), nullable=True),
        sa.Column('cancel', sa.Boolean(), nullable=False),
        sa.Column('created', sa.String(length=32), nullable=False),
        sa.Column('started', sa.String(length=32), nullable=True),
        sa.Column('ended', sa.String(length=32), nullable=True),
        sa.Column('problem', sa.Text(), nullable=True),
        sa.Column('result', KEY, nullable=True),
        sa.ForeignKeyConstraint(['project'], ['project.id'], name=op.f('fk_job_project')),
        sa.ForeignKeyConstraint(['result'], ['result.id'], name=op.f('fk_job_result')),
        sa.PrimaryKeyConstraint('id', name=op.f('pk_job')),
        sa.UniqueConstraint('uuid', name=op.f('uq_job_uuid')),
    )
    op.create_index(op.f('ix_job_state'), 'job', ['state'])
    op.create_index(op.f('ix_job_project'), 'job', ['project'])
    op.create_table(
        'result_part',
        sa.Column('result', KEY, nullable=False),
        sa.Column('name', sa.String(length=64), nullable=False),
        sa.Column('kind', sa.String(length=16), nullable=False),
        sa.Column('data', sa.LargeBinary(), nullable=False),
        sa.Column('arrays', sa.Text(), nullable=False),
        sa.Column('document', KEY, nullable=True),
        sa.ForeignKeyConstraint(['document'], ['document.id'], name=op.f('fk_result_part_document')),
        sa.ForeignKeyConstraint(['result'], ['result.id'], name=op.f('fk_result_part_result')),
        sa.PrimaryKeyConstraint('result', 'name', name=op.f('pk_result_part')),
    )
    op.create_table(
        'result_block',
        sa.Column('result', KEY, nullable=False),
        sa.Column('part', sa.String(length=64), nullable=False),
        sa.Column('array', sa.String(length=64), nullable=False),
        sa.Column('number', sa.Integer(), nullable=False),
        sa.Column('data', sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(['result'], ['result.id'], name=op.f('fk_result_block_result')),
        sa.PrimaryKeyConstraint('result', 'part', 'array', 'number', name=op.f('pk_result_block')),
    )
