"""Weights of blend shapes, the ninth channel of tracks."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0020'
down_revision = '0019'
branch_labels = None
depends_on = None

BEFORE = 'Tx Ty Tz Rx Ry Rz SF residual'


def upgrade() -> None:
    for end in ('min', 'max'):
        op.add_column('track', sa.Column(f'{end}_weight', sa.Float(precision=53)))
    store = sa.table('store', sa.column('name'), sa.column('value'))
    held = (store.c.name == 'channels', store.c.value == BEFORE)
    op.execute(sa.update(store).where(*held).values(value=f'{BEFORE} weight'))
