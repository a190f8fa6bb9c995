"""Numbers of rolled-up readings; digests of the rows there are, as they stand, for `verify`.

Revision: 0012, after 0011.
"""

from datetime import UTC, datetime

import sqlalchemy as sa
from alembic import op
from sqlalchemy.orm import Session

from db.attesting import attest
from db.history import History

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "reading_range",
        sa.Column("source", sa.String(length=100), nullable=False),
        sa.Column("first", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("last", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("source", "first", name=op.f("pk_reading_range")),
    )
    op.create_index(op.f("ix_reading_range_source_last"), "reading_range", ["source", "last"])
    with Session(op.get_bind()) as session:
        history = History(session, "migration", lambda: datetime.now(UTC))
        attest(session, history)
        history.finish()
        session.flush()


def downgrade() -> None:
    op.drop_table("reading_range")
