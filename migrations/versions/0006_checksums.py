"""Rows have checksums of what they mean, and the store says how its tracks are written.

The sums of rows that are there are written once all migrations have run (`actions.keeping.keep_store`).
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0006'
down_revision = '0005'
branch_labels = None
depends_on = None

SEALED = (
    'project', 'token', 'commit', 'document', 'revision', 'skeleton', 'content', 'header', 'property', 'bone', 'timeline',
    'frame_run', 'shape', 'shape_run', 'span', 'track', 'upload_block', 'document_upload', 'joint_mapping', 'result',
    'result_part', 'result_block',
)
LAYOUT = {'frames in a track': '256', 'channels': 'Tx Ty Tz Rx Ry Rz SF residual', 'codec': 'pcodec 1'}


def upgrade() -> None:
    for table in SEALED:
        op.add_column(table, sa.Column('checksum', sa.BigInteger))
    op.add_column('track', sa.Column('data_checksum', sa.BigInteger))
    store = op.create_table(
        'store',
        sa.Column('name', sa.String(32), primary_key=True),
        sa.Column('value', sa.Text, nullable=False),
    )
    op.bulk_insert(store, [{'name': name, 'value': value} for name, value in LAYOUT.items()])
