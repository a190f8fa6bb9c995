"""Indexes in the order that lists are read in.

Revision: 0009, after 0008.
"""

from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("session", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_session_state"))
        batch_op.create_index(batch_op.f("ix_session_state_created_at"), ["state", "created_at"], unique=False)

    with op.batch_alter_table("influence", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_influence_machine_type"))
        batch_op.create_index(
            batch_op.f("ix_influence_machine_type_machine_id_learned_at"),
            ["machine_type", "machine_id", "learned_at"],
            unique=False,
        )

    with op.batch_alter_table("audit", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_audit_kind_id"), ["kind", "id"], unique=False)

    with op.batch_alter_table("balancer_answer", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_balancer_answer_machine_id_taken_at"), ["machine_id", "taken_at"], unique=False
        )


def downgrade() -> None:
    with op.batch_alter_table("balancer_answer", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_balancer_answer_machine_id_taken_at"))

    with op.batch_alter_table("audit", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_audit_kind_id"))

    with op.batch_alter_table("influence", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_influence_machine_type_machine_id_learned_at"))
        batch_op.create_index(batch_op.f("ix_influence_machine_type"), ["machine_type"], unique=False)

    with op.batch_alter_table("session", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_session_state_created_at"))
        batch_op.create_index(batch_op.f("ix_session_state"), ["state"], unique=False)
