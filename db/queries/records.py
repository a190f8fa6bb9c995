"""Machines, boxes, sessions with their parts, and what was learned of machines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import func, insert, or_, select
from sqlalchemy.orm import aliased

from db.pubsub import stream
from db.queries.base import Queries
from db.rows import (
    NOT_CLOSED,
    ArrangementRow,
    Base,
    CatalogueRow,
    CorrectionRow,
    DesignRunRow,
    DesignStudyRow,
    InfluenceRow,
    MachineRow,
    PartEntryRow,
    PlaceSetRow,
    PlanRow,
    RunRow,
    SessionRow,
    StopRow,
)
from db.set_apart import readable


class Records(Queries):
    """The records that people keep."""

    def machines(self, limit: int, offset: int) -> Sequence[MachineRow]:
        """Machines, newest first."""
        query = select(MachineRow).order_by(MachineRow.created_at.desc(), MachineRow.id)
        return readable(self._page(query, limit, offset))

    def machine_named(self, name: str) -> MachineRow | None:
        """The machine of this name."""
        return self._session.scalars(select(MachineRow).where(MachineRow.name == name)).one_or_none()

    def catalogues(self, limit: int, offset: int) -> Sequence[CatalogueRow]:
        """Catalogues, newest first."""
        query = select(CatalogueRow).order_by(CatalogueRow.created_at.desc(), CatalogueRow.id)
        return readable(self._page(query, limit, offset))

    def catalogue_named(self, name: str) -> CatalogueRow | None:
        """The catalogue of this name."""
        return self._session.scalars(select(CatalogueRow).where(CatalogueRow.name == name)).one_or_none()

    def sessions(
        self,
        limit: int,
        offset: int,
        *,
        machine_id: str | None = None,
        state: str | None = None,
        words: str | None = None,
    ) -> Sequence[SessionRow]:
        """Sessions, newest first; words: those whose machine, technician or note has them, in any case."""
        query = select(SessionRow).order_by(SessionRow.created_at.desc(), SessionRow.id)
        if machine_id is not None:
            query = query.where(SessionRow.machine_id == machine_id)
        if state is not None:
            query = query.where(SessionRow.state == state)
        if words is not None:
            searched = (SessionRow.machine_name, SessionRow.technician, SessionRow.note)
            query = query.where(or_(*(column.icontains(words, autoescape=True) for column in searched)))
        return self._page(query, limit, offset)

    def open_sessions(self, machine_id: str) -> Sequence[SessionRow]:
        """Sessions on a machine that are not closed, newest first."""
        return self._session.scalars(
            select(SessionRow)
            .where(SessionRow.machine_id == machine_id, NOT_CLOSED)
            .order_by(SessionRow.created_at.desc())
        ).all()

    # ------------------------------------------------------------ parts and their places
    def arrangements(
        self, limit: int, offset: int, *, machine_id: str | None = None, session_id: str | None = None
    ) -> Sequence[ArrangementRow]:
        """Arrangements, newest first."""
        query = select(ArrangementRow).order_by(ArrangementRow.created_at.desc(), ArrangementRow.id)
        if machine_id is not None:
            query = query.where(ArrangementRow.machine_id == machine_id)
        if session_id is not None:
            query = query.where(ArrangementRow.session_id == session_id)
        return readable(self._page(query, limit, offset))

    def place_sets(self, machine_id: str) -> Sequence[PlaceSetRow]:
        """A machine's sets of places, by name."""
        query = select(PlaceSetRow).where(PlaceSetRow.machine_id == machine_id).order_by(PlaceSetRow.name)
        return self._session.scalars(query).all()

    def part_entries(
        self, machine_id: str, limit: int, offset: int, *, part: str | None = None
    ) -> Sequence[PartEntryRow]:
        """History of a machine's parts, newest first; part: of this one."""
        query = select(PartEntryRow).where(PartEntryRow.machine_id == machine_id).order_by(PartEntryRow.id.desc())
        if part is not None:
            query = query.where(PartEntryRow.part == part)
        return readable(self._page(query, limit, offset))

    def latest_part_entries(self, machine_id: str) -> Sequence[PartEntryRow]:
        """The latest line of every part that was ever on a machine."""
        latest = (
            select(func.max(PartEntryRow.id)).where(PartEntryRow.machine_id == machine_id).group_by(PartEntryRow.part)
        )
        return self._session.scalars(
            select(PartEntryRow).where(PartEntryRow.id.in_(latest)).order_by(PartEntryRow.part)
        ).all()

    # ------------------------------------------------------------ design studies
    def design_studies(self, limit: int, offset: int) -> Sequence[DesignStudyRow]:
        """Design studies, the one changed last first."""
        query = select(DesignStudyRow).order_by(DesignStudyRow.updated_at.desc(), DesignStudyRow.id)
        return readable(self._page(query, limit, offset))

    def design_runs(self, limit: int, offset: int, *, study_id: str | None = None) -> Sequence[DesignRunRow]:
        """Runs of design studies, newest first; study_id: of this one."""
        query = select(DesignRunRow).order_by(DesignRunRow.created_at.desc(), DesignRunRow.id)
        if study_id is not None:
            query = query.where(DesignRunRow.study_id == study_id)
        return readable(self._page(query, limit, offset))

    # ------------------------------------------------------------ of a session
    def runs(self, session_id: str) -> Sequence[RunRow]:
        """Runs of a session, in order."""
        return self._numbered(RunRow, session_id)

    def corrections(self, session_id: str) -> Sequence[CorrectionRow]:
        """Corrections of a session, in order."""
        return self._numbered(CorrectionRow, session_id)

    def plans(self, session_id: str) -> Sequence[PlanRow]:
        """Plans of a session, in order."""
        return self._numbered(PlanRow, session_id)

    def stops(self, session_id: str) -> Sequence[StopRow]:
        """Stops of a session to change masses, in order."""
        return self._numbered(StopRow, session_id)

    def import_session(
        self, session: Mapping[str, Any], parts: Mapping[type[Base], Sequence[Mapping[str, Any]]], told: dict[str, Any]
    ) -> None:
        """Store a session of another service with its parts, as they are; a closed one is sealed.

        Past the ORM: its version and its history are not those of this service. told: what the one entry tells.
        """
        session_id = str(session["id"])
        self._session.execute(insert(SessionRow), [dict(session)])
        for kind, rows in parts.items():
            if rows:
                self._session.execute(insert(kind), [{**row, "session_id": session_id} for row in rows])
        stream(self._session, (session_id, session["machine_id"]))
        if self._history is not None:
            stored = [(part.__tablename__, row["id"]) for part, rows in parts.items() for row in rows]
            stored.append((SessionRow.__tablename__, session_id))
            self._history.note("imported", "session", session_id, told, session_id=session_id, rows=stored)
            if session["state"] == "closed":
                self._history.seal(session_id)

    # ------------------------------------------------------------ influence
    def influences(self, machine_id: str, limit: int, offset: int = 0) -> Sequence[InfluenceRow]:
        """What a machine's coefficients were, latest first."""
        query = select(InfluenceRow).where(InfluenceRow.machine_id == machine_id)
        return readable(self._page(query.order_by(InfluenceRow.learned_at.desc(), InfluenceRow.id), limit, offset))

    def influence_of(self, session_id: str) -> InfluenceRow | None:
        """What a session taught."""
        return self._session.scalars(select(InfluenceRow).where(InfluenceRow.session_id == session_id)).one_or_none()

    def latest_influences_of_type(self, machine_type: str) -> Sequence[InfluenceRow]:
        """The latest coefficients of each machine of a type, latest first."""
        # From one machine to the next by the index: a machine learns in every session, and only its last word counts.
        of_type = InfluenceRow.machine_type == machine_type
        first = select(func.min(InfluenceRow.machine_id).label("id")).where(of_type).cte("taught", recursive=True)
        following = select(func.min(InfluenceRow.machine_id)).where(of_type, InfluenceRow.machine_id > first.c.id)
        taught = first.union_all(select(following.scalar_subquery()).where(first.c.id.is_not(None)))
        earlier = aliased(InfluenceRow)
        latest = (
            select(earlier.id)
            .where(earlier.machine_type == machine_type, earlier.machine_id == taught.c.id)
            .order_by(earlier.learned_at.desc(), earlier.id)
            .limit(1)
        )
        query = select(InfluenceRow).join(taught, InfluenceRow.id == latest.scalar_subquery())
        return readable(self._session.scalars(query.order_by(InfluenceRow.learned_at.desc(), InfluenceRow.id)).all())
