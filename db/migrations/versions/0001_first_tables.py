"""First tables.

Revision: 0001, after nothing.
"""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "catalogue",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("name", sa.String(length=100), nullable=False),
        sa.Column("items", sa.Text(), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_catalogue")),
        sa.UniqueConstraint("name", name=op.f("uq_catalogue_name")),
    )
    with op.batch_alter_table("catalogue", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_catalogue_created_at"), ["created_at"], unique=False)

    op.create_table(
        "machine",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("name", sa.String(length=100), nullable=False),
        sa.Column("spec", sa.Text(), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("updated_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_machine")),
        sa.UniqueConstraint("name", name=op.f("uq_machine_name")),
    )
    with op.batch_alter_table("machine", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_machine_created_at"), ["created_at"], unique=False)

    op.create_table(
        "session",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("machine_id", sa.String(length=32), nullable=False),
        sa.Column("machine_name", sa.String(length=100), nullable=False),
        sa.Column("machine", sa.Text(), nullable=False),
        sa.Column("catalogue_id", sa.String(length=32), nullable=True),
        sa.Column("state", sa.String(length=16), nullable=False),
        sa.Column("technician", sa.String(length=100), nullable=True),
        sa.Column("note", sa.Text(), nullable=True),
        sa.Column("run_out", sa.Text(), nullable=False),
        sa.Column("on_rotor", sa.Text(), nullable=False),
        sa.Column("fitted_plan_id", sa.String(length=32), nullable=True),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("closed_at", sa.DateTime(timezone=True), nullable=True),
        sa.ForeignKeyConstraint(["catalogue_id"], ["catalogue.id"], name=op.f("fk_session_catalogue_id")),
        sa.ForeignKeyConstraint(["machine_id"], ["machine.id"], name=op.f("fk_session_machine_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_session")),
    )
    with op.batch_alter_table("session", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_session_created_at"), ["created_at"], unique=False)
        batch_op.create_index(
            batch_op.f("ix_session_machine_id_created_at"), ["machine_id", "created_at"], unique=False
        )
        batch_op.create_index(batch_op.f("ix_session_state"), ["state"], unique=False)

    op.create_table(
        "source",
        sa.Column("name", sa.String(length=100), nullable=False),
        sa.Column("machine_id", sa.String(length=32), nullable=False),
        sa.Column("bound_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(["machine_id"], ["machine.id"], name=op.f("fk_source_machine_id")),
        sa.PrimaryKeyConstraint("name", name=op.f("pk_source")),
    )
    op.create_table(
        "balancer_answer",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("source", sa.String(length=100), nullable=False),
        sa.Column("sequence", sa.BigInteger(), nullable=False),
        sa.Column("machine_id", sa.String(length=32), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=True),
        sa.Column("taken_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("masses", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["machine_id"], ["machine.id"], name=op.f("fk_balancer_answer_machine_id")),
        sa.ForeignKeyConstraint(["session_id"], ["session.id"], name=op.f("fk_balancer_answer_session_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_balancer_answer")),
        sa.UniqueConstraint("source", "sequence", name=op.f("uq_balancer_answer_source_sequence")),
    )
    with op.batch_alter_table("balancer_answer", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_balancer_answer_session_id_taken_at"), ["session_id", "taken_at"], unique=False
        )

    op.create_table(
        "correction",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("correction", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["session_id"], ["session.id"], name=op.f("fk_correction_session_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_correction")),
        sa.UniqueConstraint("session_id", "number", name=op.f("uq_correction_session_id_number")),
    )
    op.create_table(
        "influence",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("machine_id", sa.String(length=32), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=False),
        sa.Column("machine_type", sa.String(length=100), nullable=True),
        sa.Column("learned_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("learned", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["machine_id"], ["machine.id"], name=op.f("fk_influence_machine_id")),
        sa.ForeignKeyConstraint(["session_id"], ["session.id"], name=op.f("fk_influence_session_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_influence")),
        sa.UniqueConstraint("session_id", name=op.f("uq_influence_session_id")),
    )
    with op.batch_alter_table("influence", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_influence_machine_id_learned_at"), ["machine_id", "learned_at"], unique=False
        )
        batch_op.create_index(batch_op.f("ix_influence_machine_type"), ["machine_type"], unique=False)

    op.create_table(
        "plan",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("plan", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["session_id"], ["session.id"], name=op.f("fk_plan_session_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_plan")),
        sa.UniqueConstraint("session_id", "number", name=op.f("uq_plan_session_id_number")),
    )
    op.create_table(
        "reading",
        sa.Column("id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), autoincrement=True, nullable=False),
        sa.Column("source", sa.String(length=100), nullable=False),
        sa.Column("sequence", sa.BigInteger(), nullable=False),
        sa.Column("machine_id", sa.String(length=32), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=True),
        sa.Column("taken_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("sensor", sa.String(length=100), nullable=False),
        sa.Column("amplitude", sa.Double(), nullable=False),
        sa.Column("phase_deg", sa.Double(), nullable=True),
        sa.Column("speed_rpm", sa.Double(), nullable=True),
        sa.Column("scatter", sa.Double(), nullable=True),
        sa.Column("overall_rms", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(["machine_id"], ["machine.id"], name=op.f("fk_reading_machine_id")),
        sa.ForeignKeyConstraint(["session_id"], ["session.id"], name=op.f("fk_reading_session_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_reading")),
        sa.UniqueConstraint("source", "sequence", name=op.f("uq_reading_source_sequence")),
    )
    with op.batch_alter_table("reading", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_reading_session_id_taken_at"), ["session_id", "taken_at"], unique=False)
        batch_op.create_index(batch_op.f("ix_reading_source_taken_at"), ["source", "taken_at"], unique=False)

    op.create_table(
        "run",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("run", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["session_id"], ["session.id"], name=op.f("fk_run_session_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_run")),
        sa.UniqueConstraint("session_id", "number", name=op.f("uq_run_session_id_number")),
    )
    op.create_table(
        "stock_entry",
        sa.Column("id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), autoincrement=True, nullable=False),
        sa.Column("catalogue_id", sa.String(length=32), nullable=False),
        sa.Column("item", sa.Integer(), nullable=False),
        sa.Column("kind", sa.String(length=16), nullable=False),
        sa.Column("pieces", sa.Integer(), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=True),
        sa.Column("plan_id", sa.String(length=32), nullable=True),
        sa.Column("at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(["catalogue_id"], ["catalogue.id"], name=op.f("fk_stock_entry_catalogue_id")),
        sa.ForeignKeyConstraint(["plan_id"], ["plan.id"], name=op.f("fk_stock_entry_plan_id")),
        sa.ForeignKeyConstraint(["session_id"], ["session.id"], name=op.f("fk_stock_entry_session_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_stock_entry")),
    )
    with op.batch_alter_table("stock_entry", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_stock_entry_catalogue_id_item"), ["catalogue_id", "item"], unique=False)


def downgrade() -> None:
    with op.batch_alter_table("stock_entry", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_stock_entry_catalogue_id_item"))

    op.drop_table("stock_entry")
    op.drop_table("run")
    with op.batch_alter_table("reading", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_reading_source_taken_at"))
        batch_op.drop_index(batch_op.f("ix_reading_session_id_taken_at"))

    op.drop_table("reading")
    op.drop_table("plan")
    with op.batch_alter_table("influence", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_influence_machine_type"))
        batch_op.drop_index(batch_op.f("ix_influence_machine_id_learned_at"))

    op.drop_table("influence")
    op.drop_table("correction")
    with op.batch_alter_table("balancer_answer", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_balancer_answer_session_id_taken_at"))

    op.drop_table("balancer_answer")
    op.drop_table("source")
    with op.batch_alter_table("session", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_session_state"))
        batch_op.drop_index(batch_op.f("ix_session_machine_id_created_at"))
        batch_op.drop_index(batch_op.f("ix_session_created_at"))

    op.drop_table("session")
    with op.batch_alter_table("machine", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_machine_created_at"))

    op.drop_table("machine")
    with op.batch_alter_table("catalogue", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_catalogue_created_at"))

    op.drop_table("catalogue")
