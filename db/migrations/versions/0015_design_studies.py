"""Design studies, their runs, and how far these are.

Revision: 0015, after 0014.
"""

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "design_study",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("updated_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("study", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_design_study")),
    )
    with op.batch_alter_table("design_study", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_design_study_updated_at"), ["updated_at"], unique=False)

    op.create_table(
        "design_run",
        sa.Column("id", sa.String(length=32), nullable=False),
        sa.Column("study_id", sa.String(length=32), nullable=True),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("run", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["study_id"], ["design_study.id"], name=op.f("fk_design_run_study_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_design_run")),
    )
    with op.batch_alter_table("design_run", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_design_run_created_at"), ["created_at"], unique=False)
        batch_op.create_index(batch_op.f("ix_design_run_study_id_created_at"), ["study_id", "created_at"], unique=False)

    op.create_table(
        "design_progress",
        sa.Column("design_run_id", sa.String(length=32), nullable=False),
        sa.Column("beat_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("stop", sa.Boolean(), nullable=False),
        sa.Column("progress", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["design_run_id"], ["design_run.id"], name=op.f("fk_design_progress_design_run_id")),
        sa.PrimaryKeyConstraint("design_run_id", name=op.f("pk_design_progress")),
    )


def downgrade() -> None:
    op.drop_table("design_progress")
    with op.batch_alter_table("design_run", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_design_run_study_id_created_at"))
        batch_op.drop_index(batch_op.f("ix_design_run_created_at"))

    op.drop_table("design_run")
    with op.batch_alter_table("design_study", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_design_study_updated_at"))

    op.drop_table("design_study")
