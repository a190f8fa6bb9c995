"""The tables. Nested values are documents; what is searched or counted is a column."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import (
    BigInteger,
    CheckConstraint,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Text,
    UniqueConstraint,
    text,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

from db.types import Document, UtcTime
from service.model.access import Scope
from service.model.arrangement import Arrangement
from service.model.correction import Correction
from service.model.counters import FrameCounter
from service.model.design_run import DesignProgress, DesignRun, DesignStudy
from service.model.findings import Findings
from service.model.influence import LearnedInfluence
from service.model.machine import CatalogueItem, Machine
from service.model.parts import PartRecord, Place
from service.model.plan import Plan
from service.model.run import MassOnRotor, Run, RunOut
from service.model.session import AsFoundPiece
from service.model.stop import Stop

_KEY = String(32)
_AUTO_KEY = BigInteger().with_variant(Integer, "sqlite")


class Base(DeclarativeBase):
    """Every constraint has a name, so that migrations can drop it on any engine."""

    metadata = MetaData(
        naming_convention={
            "ix": "ix_%(table_name)s_%(column_0_N_name)s",
            "uq": "uq_%(table_name)s_%(column_0_N_name)s",
            "ck": "ck_%(table_name)s_%(constraint_name)s",
            "fk": "fk_%(table_name)s_%(column_0_N_name)s",
            "pk": "pk_%(table_name)s",
        }
    )


class MachineRow(Base):
    """A machine; sessions carry their own copy of it."""

    __tablename__ = "machine"

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    name: Mapped[str] = mapped_column(String(100), unique=True)
    spec: Mapped[Machine] = mapped_column(Document(Machine, recurring=True))
    created_at: Mapped[datetime] = mapped_column(UtcTime, index=True)
    updated_at: Mapped[datetime] = mapped_column(UtcTime)


class CatalogueRow(Base):
    """A box of stock masses; its row is locked while stock moves."""

    __tablename__ = "catalogue"

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    name: Mapped[str] = mapped_column(String(100), unique=True)
    items: Mapped[tuple[CatalogueItem, ...]] = mapped_column(Document(tuple[CatalogueItem, ...]))
    created_at: Mapped[datetime] = mapped_column(UtcTime, index=True)


class StockEntryRow(Base):
    """One movement of one catalogue item: pieces into the box, pieces held for a plan. Nothing here is ever changed."""

    __tablename__ = "stock_entry"
    __table_args__ = (
        Index(None, "catalogue_id", "id"),
        Index(None, "catalogue_id", "item", "id"),
        Index(None, "catalogue_id", "until"),
    )

    id: Mapped[int] = mapped_column(_AUTO_KEY, primary_key=True, autoincrement=True)
    catalogue_id: Mapped[str] = mapped_column(_KEY, ForeignKey("catalogue.id"))
    item: Mapped[int]
    kind: Mapped[str] = mapped_column(String(16))
    pieces: Mapped[int]
    held: Mapped[int] = mapped_column(server_default="0")
    session_id: Mapped[str | None] = mapped_column(_KEY, ForeignKey("session.id"), index=True)
    plan_id: Mapped[str | None] = mapped_column(_KEY, ForeignKey("plan.id"), index=True)
    until: Mapped[datetime | None] = mapped_column(UtcTime)
    note: Mapped[str | None] = mapped_column(Text)
    at: Mapped[datetime] = mapped_column(UtcTime)


class StockBalanceRow(Base):
    """The sum of an item's movements: a box costs the same after many years; the engine refuses less than none."""

    __tablename__ = "stock_balance"
    __table_args__ = (CheckConstraint("on_hand >= 0", name="on_hand"),)

    catalogue_id: Mapped[str] = mapped_column(_KEY, ForeignKey("catalogue.id"), primary_key=True)
    item: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    on_hand: Mapped[int]


NOT_CLOSED = text("state <> 'closed'")
"""Word for word in query and index, or SQLite does not see that the index serves: most sessions are closed."""


class SessionRow(Base):
    """A session: one drum being balanced."""

    __tablename__ = "session"
    __table_args__ = (
        Index(None, "machine_id", "created_at"),
        Index(None, "state", "created_at"),
        Index(
            "ix_session_not_closed", "machine_id", "created_at", sqlite_where=NOT_CLOSED, postgresql_where=NOT_CLOSED
        ),
    )

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    machine_id: Mapped[str] = mapped_column(_KEY, ForeignKey("machine.id"))
    machine_name: Mapped[str] = mapped_column(String(100))
    machine: Mapped[Machine] = mapped_column(Document(Machine, recurring=True))
    catalogue_id: Mapped[str | None] = mapped_column(_KEY, ForeignKey("catalogue.id"))
    state: Mapped[str] = mapped_column(String(16))
    technician: Mapped[str | None] = mapped_column(String(100))
    note: Mapped[str | None] = mapped_column(Text)
    run_out: Mapped[tuple[RunOut, ...]] = mapped_column(Document(tuple[RunOut, ...]))
    on_rotor: Mapped[tuple[AsFoundPiece, ...]] = mapped_column(Document(tuple[AsFoundPiece, ...]))
    fitted_plan_id: Mapped[str | None] = mapped_column(_KEY)
    version: Mapped[int] = mapped_column(default=1, server_default="1")
    created_at: Mapped[datetime] = mapped_column(UtcTime, index=True)
    closed_at: Mapped[datetime | None] = mapped_column(UtcTime)


class RunRow(Base):
    """A run of a session, as a document."""

    __tablename__ = "run"
    __table_args__ = (UniqueConstraint("session_id", "number"),)

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    session_id: Mapped[str] = mapped_column(_KEY, ForeignKey("session.id"))
    number: Mapped[int]
    run: Mapped[Run] = mapped_column(Document(Run))


class CorrectionRow(Base):
    """A correction of a session, as a document."""

    __tablename__ = "correction"
    __table_args__ = (UniqueConstraint("session_id", "number"),)

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    session_id: Mapped[str] = mapped_column(_KEY, ForeignKey("session.id"))
    number: Mapped[int]
    correction: Mapped[Correction] = mapped_column(Document(Correction))


class InfluenceRow(Base):
    """What a machine's influence coefficients were after a session; nothing here is ever changed."""

    __tablename__ = "influence"
    __table_args__ = (
        Index(None, "machine_id", "learned_at"),
        Index(None, "machine_type", "machine_id", "learned_at"),
        UniqueConstraint("session_id"),
    )

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    machine_id: Mapped[str] = mapped_column(_KEY, ForeignKey("machine.id"))
    session_id: Mapped[str] = mapped_column(_KEY, ForeignKey("session.id"))
    machine_type: Mapped[str | None] = mapped_column(String(100))
    learned_at: Mapped[datetime] = mapped_column(UtcTime)
    learned: Mapped[LearnedInfluence] = mapped_column(Document(LearnedInfluence))


class PlanRow(Base):
    """A plan of a session, as a document."""

    __tablename__ = "plan"
    __table_args__ = (UniqueConstraint("session_id", "number"),)

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    session_id: Mapped[str] = mapped_column(_KEY, ForeignKey("session.id"))
    number: Mapped[int]
    plan: Mapped[Plan] = mapped_column(Document(Plan))


class ArrangementRow(Base):
    """An arrangement of weighed parts, as a document; with or without a machine and a session."""

    __tablename__ = "arrangement"
    __table_args__ = (Index(None, "machine_id", "created_at"), Index(None, "session_id", "created_at"))

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    machine_id: Mapped[str | None] = mapped_column(_KEY, ForeignKey("machine.id"))
    session_id: Mapped[str | None] = mapped_column(_KEY, ForeignKey("session.id"))
    created_at: Mapped[datetime] = mapped_column(UtcTime, index=True)
    arrangement: Mapped[Arrangement] = mapped_column(Document(Arrangement))


class DesignStudyRow(Base):
    """A design study as it stands, as a document; what it was before is in the history."""

    __tablename__ = "design_study"

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    created_at: Mapped[datetime] = mapped_column(UtcTime)
    updated_at: Mapped[datetime] = mapped_column(UtcTime, index=True)
    study: Mapped[DesignStudy] = mapped_column(Document(DesignStudy))


class DesignRunRow(Base):
    """A computation of an optimum or a front, with or without a stored study, and what it found."""

    __tablename__ = "design_run"
    __table_args__ = (Index(None, "study_id", "created_at"),)

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    study_id: Mapped[str | None] = mapped_column(_KEY, ForeignKey("design_study.id"))
    created_at: Mapped[datetime] = mapped_column(UtcTime, index=True)
    run: Mapped[DesignRun] = mapped_column(Document(DesignRun))


class DesignProgressRow(Base):
    """How far a run is, and whether it is to stop: written while it lasts, without history, removed at its end."""

    __tablename__ = "design_progress"

    design_run_id: Mapped[str] = mapped_column(_KEY, ForeignKey("design_run.id"), primary_key=True)
    beat_at: Mapped[datetime] = mapped_column(UtcTime)
    stop: Mapped[bool]
    progress: Mapped[DesignProgress] = mapped_column(Document(DesignProgress))


class PlaceSetRow(Base):
    """A machine's set of places for one kind of part."""

    __tablename__ = "place_set"
    __table_args__ = (UniqueConstraint("machine_id", "name"),)

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    machine_id: Mapped[str] = mapped_column(_KEY, ForeignKey("machine.id"))
    name: Mapped[str] = mapped_column(String(100))
    places: Mapped[tuple[Place, ...]] = mapped_column(Document(tuple[Place, ...]))
    updated_at: Mapped[datetime] = mapped_column(UtcTime)


class PartEntryRow(Base):
    """One line of a part's history on a machine; nothing here is ever changed."""

    __tablename__ = "part_entry"
    __table_args__ = (Index(None, "machine_id", "id"), Index(None, "machine_id", "part", "id"))

    id: Mapped[int] = mapped_column(_AUTO_KEY, primary_key=True, autoincrement=True)
    machine_id: Mapped[str] = mapped_column(_KEY, ForeignKey("machine.id"))
    part: Mapped[str] = mapped_column(String(100))
    arrangement_id: Mapped[str | None] = mapped_column(_KEY, ForeignKey("arrangement.id"), index=True)
    record: Mapped[PartRecord] = mapped_column(Document(PartRecord))


class StopRow(Base):
    """A stop of the machine to change masses, as a document."""

    __tablename__ = "stop"
    __table_args__ = (UniqueConstraint("session_id", "number"),)

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    session_id: Mapped[str] = mapped_column(_KEY, ForeignKey("session.id"))
    number: Mapped[int]
    stop: Mapped[Stop] = mapped_column(Document(Stop))


class SourceRow(Base):
    """Which machine a source of readings is mounted on."""

    __tablename__ = "source"

    name: Mapped[str] = mapped_column(String(100), primary_key=True)
    machine_id: Mapped[str] = mapped_column(_KEY, ForeignKey("machine.id"))
    bound_at: Mapped[datetime] = mapped_column(UtcTime)


class SourceMarkRow(Base):
    """How far the counters of a source's frames were with the readings before; a later mark has a higher number."""

    __tablename__ = "source_mark"

    source: Mapped[str] = mapped_column(String(100), primary_key=True)
    number: Mapped[int] = mapped_column(BigInteger)
    counters: Mapped[tuple[FrameCounter, ...]] = mapped_column(Document(tuple[FrameCounter, ...]))


class SourceClockRow(Base):
    """How far a source's clock is off, by what it sent; `service` keeps the rules (`SourceClock`).

    offset_s: what is added to its times. stated: by what the source itself said its clock was at. bucket_at, bucket_s,
    before_s: the least offsets seen since then and in the span before. steady_from: when it is relied on. ahead_s,
    apart_at, apart: of the last reading that was set apart for its time, and how many were.
    """

    __tablename__ = "source_clock"

    source: Mapped[str] = mapped_column(String(100), primary_key=True)
    stated: Mapped[bool | None]
    offset_s: Mapped[float | None]
    bucket_at: Mapped[datetime | None] = mapped_column(UtcTime)
    bucket_s: Mapped[float | None]
    before_s: Mapped[float | None]
    steady_from: Mapped[datetime | None] = mapped_column(UtcTime)
    ahead_s: Mapped[float | None]
    apart_at: Mapped[datetime | None] = mapped_column(UtcTime)
    apart: Mapped[int] = mapped_column(default=0, server_default="0")


LIVE = text("session_id IS NULL AND apart IS NULL")
"""Of readings for whatever session is open; word for word in query and index."""
LIVE_IN_SESSION = text("session_id IS NOT NULL AND apart IS NULL")
SET_APART = text("apart IS NOT NULL")


class ReadingRow(Base):
    """One reading of a source; (source, sequence) makes it idempotent.

    received_at: when the service had it; null: stored by a version that did not note that. apart: why it is in no
    window, mean or run (`clock_ahead`, `withdrawn`); null for a reading like any other.
    """

    __tablename__ = "reading"
    __table_args__ = (
        UniqueConstraint("source", "sequence"),
        Index(None, "source", "taken_at"),
        Index("ix_reading_live", "source", "received_at", "id", sqlite_where=LIVE, postgresql_where=LIVE),
        Index(
            "ix_reading_live_in_session",
            "session_id",
            "received_at",
            "id",
            sqlite_where=LIVE_IN_SESSION,
            postgresql_where=LIVE_IN_SESSION,
        ),
        Index("ix_reading_apart", "source", "received_at", sqlite_where=SET_APART, postgresql_where=SET_APART),
    )

    id: Mapped[int] = mapped_column(_AUTO_KEY, primary_key=True, autoincrement=True)
    source: Mapped[str] = mapped_column(String(100))
    sequence: Mapped[int] = mapped_column(BigInteger)
    machine_id: Mapped[str] = mapped_column(_KEY, ForeignKey("machine.id"))
    session_id: Mapped[str | None] = mapped_column(_KEY, ForeignKey("session.id"))
    taken_at: Mapped[datetime] = mapped_column(UtcTime)
    sensor: Mapped[str] = mapped_column(String(100))
    amplitude: Mapped[float]
    phase_deg: Mapped[float | None]
    speed_rpm: Mapped[float | None]
    scatter: Mapped[float | None]
    overall_rms: Mapped[float | None]
    received_at: Mapped[datetime | None] = mapped_column(UtcTime)
    apart: Mapped[str | None] = mapped_column(String(16))


class ReadingFindingsRow(Base):
    """What the signal chain found beside a reading; a row of its own, so that plain readings cost no more."""

    __tablename__ = "reading_findings"
    __table_args__ = (Index(None, "source", "taken_at"),)

    source: Mapped[str] = mapped_column(String(100), primary_key=True)
    sequence: Mapped[int] = mapped_column(BigInteger, primary_key=True, autoincrement=False)
    taken_at: Mapped[datetime] = mapped_column(UtcTime)
    findings: Mapped[Findings] = mapped_column(Document(Findings))


class ReadingMinuteRow(Base):
    """What is left of the raw readings of a source and sensor in a minute; late ones have a row of their own.

    amplitude, phase_deg: of the mean vector; without a phase in all of them the mean amplitude. scatter: standard
    deviation of one reading, per real component where there are phases. last_sequence: the highest number among them.
    """

    __tablename__ = "reading_minute"
    __table_args__ = (Index(None, "source", "minute"), Index(None, "source", "last_sequence"))

    id: Mapped[int] = mapped_column(_AUTO_KEY, primary_key=True, autoincrement=True)
    source: Mapped[str] = mapped_column(String(100))
    machine_id: Mapped[str] = mapped_column(_KEY, ForeignKey("machine.id"))
    sensor: Mapped[str] = mapped_column(String(100))
    minute: Mapped[datetime] = mapped_column(UtcTime)
    readings: Mapped[int]
    last_sequence: Mapped[int] = mapped_column(BigInteger)
    amplitude: Mapped[float]
    phase_deg: Mapped[float | None]
    scatter: Mapped[float | None]
    speed_rpm: Mapped[float | None]
    overall_rms: Mapped[float | None]


class ReadingRangeRow(Base):
    """Numbers of a source's readings that were rolled up: sent again, they are known and not stored a second time."""

    __tablename__ = "reading_range"
    __table_args__ = (Index(None, "source", "last"),)

    source: Mapped[str] = mapped_column(String(100), primary_key=True)
    first: Mapped[int] = mapped_column(BigInteger, primary_key=True, autoincrement=False)
    last: Mapped[int] = mapped_column(BigInteger)


class TokenRow(Base):
    """A token; digest: SHA-256 of its secret in hexadecimal, the secret itself is nowhere. Rows are never deleted."""

    __tablename__ = "token"

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    name: Mapped[str] = mapped_column(String(100), unique=True)
    scopes: Mapped[tuple[Scope, ...]] = mapped_column(Document(tuple[Scope, ...]))
    digest: Mapped[str] = mapped_column(String(64))
    created_at: Mapped[datetime] = mapped_column(UtcTime)
    expires_at: Mapped[datetime | None] = mapped_column(UtcTime)
    revoked_at: Mapped[datetime | None] = mapped_column(UtcTime)


class LoginRow(Base):
    """A browser that logged in with a token; id: SHA-256 of its cookie's secret in hexadecimal."""

    __tablename__ = "login"

    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    token_id: Mapped[str] = mapped_column(_KEY, ForeignKey("token.id"))
    created_at: Mapped[datetime] = mapped_column(UtcTime)
    expires_at: Mapped[datetime] = mapped_column(UtcTime, index=True)


class AuditRow(Base):
    """One change: who, when, what. number, hash: its place in the chain, null for telemetry. Never changed."""

    __tablename__ = "audit"
    __table_args__ = (
        UniqueConstraint("number"),
        Index(None, "session_id", "id"),
        Index(None, "kind", "id"),
        Index(None, "kind", "key", "id"),
        Index(None, "actor", "id"),
    )

    id: Mapped[int] = mapped_column(_AUTO_KEY, primary_key=True, autoincrement=True)
    number: Mapped[int | None] = mapped_column(BigInteger)
    at: Mapped[datetime] = mapped_column(UtcTime)
    actor: Mapped[str] = mapped_column(String(100))
    action: Mapped[str] = mapped_column(String(16))
    kind: Mapped[str] = mapped_column(String(32))
    key: Mapped[str] = mapped_column(String(100))
    session_id: Mapped[str | None] = mapped_column(_KEY)
    changes: Mapped[dict[str, Any]] = mapped_column(Document(dict[str, Any]))
    hash: Mapped[str | None] = mapped_column(String(64))


class IdempotencyRow(Base):
    """What a request that bore a key was answered; id: SHA-256 of actor and key, request: of what was asked."""

    __tablename__ = "idempotency"

    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    request: Mapped[str] = mapped_column(String(64))
    status: Mapped[int]
    body: Mapped[str] = mapped_column(Text)
    expires_at: Mapped[datetime] = mapped_column(UtcTime, index=True)


class BalancerAnswerRow(Base):
    """Continuous masses that a balancer computed; idempotent like a reading."""

    __tablename__ = "balancer_answer"
    __table_args__ = (
        UniqueConstraint("source", "sequence"),
        Index(None, "machine_id", "taken_at"),
        Index(None, "session_id", "taken_at"),
    )

    id: Mapped[str] = mapped_column(_KEY, primary_key=True)
    source: Mapped[str] = mapped_column(String(100))
    sequence: Mapped[int] = mapped_column(BigInteger)
    machine_id: Mapped[str] = mapped_column(_KEY, ForeignKey("machine.id"))
    session_id: Mapped[str | None] = mapped_column(_KEY, ForeignKey("session.id"))
    taken_at: Mapped[datetime] = mapped_column(UtcTime)
    masses: Mapped[tuple[MassOnRotor, ...]] = mapped_column(Document(tuple[MassOnRotor, ...]))
    received_at: Mapped[datetime | None] = mapped_column(UtcTime)
