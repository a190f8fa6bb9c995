"""Arrangements of weighed parts, sets of places, and the history of parts.

Revision: 0014, after 0013.
"""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "place_set",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("machine_id", sa.String(length=32), nullable=False),
        sa.Column("name", sa.String(length=100), nullable=False),
        sa.Column("places", sa.Text(), nullable=False),
        sa.Column("updated_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(["machine_id"], ["machine.id"], name=op.f("fk_place_set_machine_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_place_set")),
        sa.UniqueConstraint("machine_id", "name", name=op.f("uq_place_set_machine_id_name")),
    )
    op.create_table(
        "arrangement",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("machine_id", sa.String(length=32), nullable=True),
        sa.Column("session_id", sa.String(length=32), nullable=True),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("arrangement", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["machine_id"], ["machine.id"], name=op.f("fk_arrangement_machine_id")),
        sa.ForeignKeyConstraint(["session_id"], ["session.id"], name=op.f("fk_arrangement_session_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_arrangement")),
    )
    with op.batch_alter_table("arrangement", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_arrangement_created_at"), ["created_at"], unique=False)
        batch_op.create_index(
            batch_op.f("ix_arrangement_machine_id_created_at"), ["machine_id", "created_at"], unique=False
        )
        batch_op.create_index(
            batch_op.f("ix_arrangement_session_id_created_at"), ["session_id", "created_at"], unique=False
        )

    op.create_table(
        "part_entry",
        sa.Column("id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), autoincrement=True, nullable=False),
        sa.Column("machine_id", sa.String(length=32), nullable=False),
        sa.Column("part", sa.String(length=100), nullable=False),
        sa.Column("arrangement_id", sa.String(length=32), nullable=True),
        sa.Column("record", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["arrangement_id"], ["arrangement.id"], name=op.f("fk_part_entry_arrangement_id")),
        sa.ForeignKeyConstraint(["machine_id"], ["machine.id"], name=op.f("fk_part_entry_machine_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_part_entry")),
    )
    with op.batch_alter_table("part_entry", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_part_entry_arrangement_id"), ["arrangement_id"], unique=False)
        batch_op.create_index(batch_op.f("ix_part_entry_machine_id_id"), ["machine_id", "id"], unique=False)
        batch_op.create_index(
            batch_op.f("ix_part_entry_machine_id_part_id"), ["machine_id", "part", "id"], unique=False
        )


def downgrade() -> None:
    with op.batch_alter_table("part_entry", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_part_entry_machine_id_part_id"))
        batch_op.drop_index(batch_op.f("ix_part_entry_machine_id_id"))
        batch_op.drop_index(batch_op.f("ix_part_entry_arrangement_id"))

    op.drop_table("part_entry")
    with op.batch_alter_table("arrangement", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_arrangement_session_id_created_at"))
        batch_op.drop_index(batch_op.f("ix_arrangement_machine_id_created_at"))
        batch_op.drop_index(batch_op.f("ix_arrangement_created_at"))

    op.drop_table("arrangement")
    op.drop_table("place_set")
