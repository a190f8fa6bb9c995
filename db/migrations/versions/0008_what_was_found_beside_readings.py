"""What was found beside readings.

Revision: 0008, after 0007.
"""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "reading_findings",
        sa.Column("source", sa.String(length=100), nullable=False),
        sa.Column("sequence", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("taken_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("findings", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("source", "sequence", name=op.f("pk_reading_findings")),
    )
    with op.batch_alter_table("reading_findings", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_reading_findings_source_taken_at"), ["source", "taken_at"], unique=False)


def downgrade() -> None:
    with op.batch_alter_table("reading_findings", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_reading_findings_source_taken_at"))

    op.drop_table("reading_findings")
