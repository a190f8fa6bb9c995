"""Raw readings rolled up; an index of open sessions.

Revision: 0006, after 0005.
"""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

NOT_CLOSED = sa.text("state <> 'closed'")


def upgrade() -> None:
    op.create_table(
        "reading_minute",
        sa.Column("id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), autoincrement=True, nullable=False),
        sa.Column("source", sa.String(length=100), nullable=False),
        sa.Column("machine_id", sa.String(length=32), nullable=False),
        sa.Column("sensor", sa.String(length=100), nullable=False),
        sa.Column("minute", sa.DateTime(timezone=True), nullable=False),
        sa.Column("readings", sa.Integer(), nullable=False),
        sa.Column("last_sequence", sa.BigInteger(), nullable=False),
        sa.Column("amplitude", sa.Double(), nullable=False),
        sa.Column("phase_deg", sa.Double(), nullable=True),
        sa.Column("scatter", sa.Double(), nullable=True),
        sa.Column("speed_rpm", sa.Double(), nullable=True),
        sa.Column("overall_rms", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(["machine_id"], ["machine.id"], name=op.f("fk_reading_minute_machine_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_reading_minute")),
    )
    with op.batch_alter_table("reading_minute", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_reading_minute_source_last_sequence"), ["source", "last_sequence"], unique=False
        )
        batch_op.create_index(batch_op.f("ix_reading_minute_source_minute"), ["source", "minute"], unique=False)

    with op.batch_alter_table("session", schema=None) as batch_op:
        batch_op.create_index(
            "ix_session_not_closed",
            ["machine_id", "created_at"],
            unique=False,
            sqlite_where=NOT_CLOSED,
            postgresql_where=NOT_CLOSED,
        )


def downgrade() -> None:
    with op.batch_alter_table("session", schema=None) as batch_op:
        batch_op.drop_index("ix_session_not_closed", sqlite_where=NOT_CLOSED, postgresql_where=NOT_CLOSED)

    with op.batch_alter_table("reading_minute", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_reading_minute_source_minute"))
        batch_op.drop_index(batch_op.f("ix_reading_minute_source_last_sequence"))

    op.drop_table("reading_minute")
