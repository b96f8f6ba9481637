"""Revisions carry the name and the project that the document had. What was before is not known: the present ones count."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = '0002'
down_revision = '0001'
branch_labels = None
depends_on = None

KEY = sa.BigInteger().with_variant(sa.Integer(), 'sqlite')
NAME = sa.String(length=1024).with_variant(sa.String(length=1024, collation='C'), 'postgresql')


def upgrade() -> None:
    op.add_column('revision', sa.Column('name', NAME, nullable=True))
    op.add_column('revision', sa.Column('project', KEY, nullable=True))
    for column in ('name', 'project'):
        op.execute(
            f'UPDATE revision SET {column} = (SELECT document.{column} FROM document '
            'WHERE document.id = revision.document)'
        )
    # SQLite cannot alter columns: it copies the table.
    with op.batch_alter_table('revision', table_kwargs={'sqlite_with_rowid': False}) as table:
        table.alter_column('name', existing_type=NAME, nullable=False)
        table.alter_column('project', existing_type=KEY, nullable=False)
        table.create_foreign_key(op.f('fk_revision_project'), 'project', ['project'], ['id'])
