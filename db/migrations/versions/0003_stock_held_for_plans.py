"""Pieces held for plans, and the balance of each item kept beside its movements.

Revision: 0003, after 0002.
"""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "stock_balance",
        sa.Column("catalogue_id", sa.String(length=32), nullable=False),
        sa.Column("item", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("on_hand", sa.Integer(), nullable=False),
        sa.CheckConstraint("on_hand >= 0", name=op.f("ck_stock_balance_on_hand")),
        sa.ForeignKeyConstraint(["catalogue_id"], ["catalogue.id"], name=op.f("fk_stock_balance_catalogue_id")),
        sa.PrimaryKeyConstraint("catalogue_id", "item", name=op.f("pk_stock_balance")),
    )
    op.execute(
        "INSERT INTO stock_balance (catalogue_id, item, on_hand) "
        "SELECT catalogue_id, item, SUM(pieces) FROM stock_entry GROUP BY catalogue_id, item"
    )
    with op.batch_alter_table("stock_entry", schema=None) as batch_op:
        batch_op.add_column(sa.Column("held", sa.Integer(), server_default="0", nullable=False))
        batch_op.add_column(sa.Column("until", sa.DateTime(timezone=True), nullable=True))
        batch_op.add_column(sa.Column("note", sa.Text(), nullable=True))
        batch_op.drop_index(batch_op.f("ix_stock_entry_catalogue_id_item"))
        batch_op.create_index(batch_op.f("ix_stock_entry_catalogue_id_id"), ["catalogue_id", "id"], unique=False)
        batch_op.create_index(
            batch_op.f("ix_stock_entry_catalogue_id_item_id"), ["catalogue_id", "item", "id"], unique=False
        )
        batch_op.create_index(batch_op.f("ix_stock_entry_catalogue_id_until"), ["catalogue_id", "until"], unique=False)
        batch_op.create_index(batch_op.f("ix_stock_entry_plan_id"), ["plan_id"], unique=False)
        batch_op.create_index(batch_op.f("ix_stock_entry_session_id"), ["session_id"], unique=False)


def downgrade() -> None:
    with op.batch_alter_table("stock_entry", schema=None) as batch_op:
        for index in ("session_id", "plan_id", "catalogue_id_until", "catalogue_id_item_id", "catalogue_id_id"):
            batch_op.drop_index(batch_op.f(f"ix_stock_entry_{index}"))
        batch_op.create_index(batch_op.f("ix_stock_entry_catalogue_id_item"), ["catalogue_id", "item"], unique=False)
        batch_op.drop_column("note")
        batch_op.drop_column("until")
        batch_op.drop_column("held")
    op.drop_table("stock_balance")
