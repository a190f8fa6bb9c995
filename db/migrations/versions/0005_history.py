"""The history with its hash chain; versions of sessions. Sessions that are closed already are sealed as they stand.

Revision: 0005, after 0004.
"""

from datetime import UTC, datetime

import sqlalchemy as sa
from alembic import op
from sqlalchemy.orm import Session

from db.history import History

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "audit",
        sa.Column("id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), autoincrement=True, nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=True),
        sa.Column("at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("actor", sa.String(length=100), nullable=False),
        sa.Column("action", sa.String(length=16), nullable=False),
        sa.Column("kind", sa.String(length=32), nullable=False),
        sa.Column("key", sa.String(length=100), nullable=False),
        sa.Column("session_id", sa.String(length=32), nullable=True),
        sa.Column("changes", sa.Text(), nullable=False),
        sa.Column("hash", sa.String(length=64), nullable=True),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_audit")),
        sa.UniqueConstraint("number", name=op.f("uq_audit_number")),
    )
    with op.batch_alter_table("audit", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_audit_actor_id"), ["actor", "id"], unique=False)
        batch_op.create_index(batch_op.f("ix_audit_kind_key_id"), ["kind", "key", "id"], unique=False)
        batch_op.create_index(batch_op.f("ix_audit_session_id_id"), ["session_id", "id"], unique=False)
    # Not by a copy of the table: others refer to it.
    op.add_column("session", sa.Column("version", sa.Integer(), server_default="1", nullable=False))

    with Session(op.get_bind()) as session:
        history = History(session, "migration", lambda: datetime.now(UTC))
        for (key,) in session.execute(sa.text("SELECT id FROM session WHERE state = 'closed' ORDER BY closed_at, id")):
            history.seal(key)
        history.finish()
        session.flush()


def downgrade() -> None:
    op.drop_column("session", "version")
    op.drop_table("audit")
