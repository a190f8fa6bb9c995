"""When readings were received, which are set apart, and how far the clocks of their sources are off.

Revision: 0013, after 0012.
"""

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None

MOMENT = sa.DateTime(timezone=True)
PARTIAL = {
    "ix_reading_live": (["source", "received_at", "id"], sa.text("session_id IS NULL AND apart IS NULL")),
    "ix_reading_live_in_session": (
        ["session_id", "received_at", "id"],
        sa.text("session_id IS NOT NULL AND apart IS NULL"),
    ),
    "ix_reading_apart": (["source", "received_at"], sa.text("apart IS NOT NULL")),
}


def upgrade() -> None:
    # Columns that may be null are added without writing a row: a site has tens of millions of readings.
    op.add_column("reading", sa.Column("received_at", MOMENT, nullable=True))
    op.add_column("reading", sa.Column("apart", sa.String(length=16), nullable=True))
    op.add_column("balancer_answer", sa.Column("received_at", MOMENT, nullable=True))
    op.drop_index(op.f("ix_reading_session_id_taken_at"), table_name="reading")
    for name, (columns, where) in PARTIAL.items():
        op.create_index(name, "reading", columns, sqlite_where=where, postgresql_where=where)
    op.create_table(
        "source_clock",
        sa.Column("source", sa.String(length=100), nullable=False),
        sa.Column("stated", sa.Boolean(), nullable=True),
        sa.Column("offset_s", sa.Double(), nullable=True),
        sa.Column("bucket_at", MOMENT, nullable=True),
        sa.Column("bucket_s", sa.Double(), nullable=True),
        sa.Column("before_s", sa.Double(), nullable=True),
        sa.Column("steady_from", MOMENT, nullable=True),
        sa.Column("ahead_s", sa.Double(), nullable=True),
        sa.Column("apart_at", MOMENT, nullable=True),
        sa.Column("apart", sa.Integer(), nullable=False, server_default="0"),
        sa.PrimaryKeyConstraint("source", name=op.f("pk_source_clock")),
    )


def downgrade() -> None:
    op.drop_table("source_clock")
    for name in PARTIAL:
        op.drop_index(name, table_name="reading")
    op.create_index(op.f("ix_reading_session_id_taken_at"), "reading", ["session_id", "taken_at"])
    for table, column in (("balancer_answer", "received_at"), ("reading", "apart"), ("reading", "received_at")):
        op.drop_column(table, column)
