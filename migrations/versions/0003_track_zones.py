"""An index that holds the zone maps of tracks, by bone: questions about samples read it instead of the tracks."""

from __future__ import annotations

from alembic import op

revision = '0003'
down_revision = '0002'
branch_labels = None
depends_on = None

COLUMNS = ['document', 'bone', 'chunk', 'from_commit', 'to_commit', 'channels']
COLUMNS += [f'{end}_{name}' for name in ('Tx', 'Ty', 'Tz', 'Rx', 'Ry', 'Rz', 'SF', 'residual') for end in ('min', 'max')]


def upgrade() -> None:
    op.create_index('ix_track_zones', 'track', COLUMNS)


def downgrade() -> None:
    op.drop_index('ix_track_zones', 'track')
