"""Design studies that are kept, and computations that last: how far they are and what they found."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from annotated_types import Ge, Gt, Le

from service.model.base import Key, Name, Seed, Text, document
from service.model.design import DesignDocument, DesignFront, DesignOutcome
from service.model.message import MessageData

RunKind = Literal["optimum", "front"]
RunState = Literal["running", "done", "stopped", "failed", "interrupted"]


@document
class DesignStudyRequest:
    """A design study to keep, or what it is to become."""

    name: Name
    """Its name."""
    document: DesignDocument
    """The document; quantities in the units that its table `units` states."""
    note: Text = ""
    """What is worth knowing of this version."""


@document
class DesignStudy:
    """A design study that is kept."""

    id: str
    """Identifier."""
    name: Name
    """Its name."""
    study: Text
    """Kind of study: linkage, flywheel, gear_pair or shaft_set."""
    version: Annotated[int, Ge(1)]
    """Counts its changes; the answer's ETag."""
    note: Text
    """What is worth knowing of this version."""
    document: DesignDocument
    """The document; quantities in the units that its table `units` states."""
    created_at: datetime
    """When it was first kept, UTC."""
    updated_at: datetime
    """When it was last changed, UTC."""


@document
class DesignRunRequest:
    """What to compute, of a study that is kept or of a document; exactly one of the two."""

    kind: RunKind = "optimum"
    """The best design, or the front of the two responses of `aim.front`."""
    study_id: Key | None = None
    """A study that is kept, as it stands now."""
    document: DesignDocument | None = None
    """A document; quantities in the units that its table `units` states."""
    method: Text | None = None
    """Of an optimum: sqp, enumeration, de_standard, differential_search, jaya, ...; null: the best known."""
    seed: Seed = 1
    """Which starts or population."""
    steps: Annotated[int, Ge(1), Le(100_000)] | None = None
    """Of an optimum: starts of sqp, generations of the others; null: enough by default."""
    points: Annotated[int, Ge(2), Le(500)] = 60
    """Of a front: how many points between its ends."""
    ceiling: Annotated[float, Gt(0), Le(1e9)] | None = None
    """Of a front: greatest second response of interest, as it is answered; null: up to the end."""
    time_limit_s: Annotated[float, Gt(0), Le(3600)] = 60.0
    """Time after which the run ends with what it has, s."""


@document
class DesignProgress:
    """How far a run is."""

    steps: Annotated[int, Ge(0)]
    """Starts, generations or points so far."""
    evaluations: Annotated[int, Ge(0)]
    """How often the objective was computed."""
    seconds: float
    """How long it has run, s."""
    value: float | None
    """Best value of what is optimised so far, in `unit`; null where no design keeps all limits yet, and of a front."""
    unit: Text
    """Its unit; empty for a number without one."""


@document
class DesignRun:
    """A computation of an optimum or a front."""

    id: str
    """Identifier."""
    state: RunState
    """running; done; stopped: by a request, with what it had; failed; interrupted: its service was stopped or lost."""
    request: DesignRunRequest
    """What was asked for."""
    document: DesignDocument
    """The document as it was computed with."""
    study_version: int | None
    """Version of the study that is kept, or null without one."""
    created_at: datetime
    """When it was begun, UTC."""
    ended_at: datetime | None
    """When it ended, UTC; null while it runs."""
    progress: DesignProgress
    """How far it is, or was at its end."""
    outcome: DesignOutcome | None = None
    """The optimum, once it has ended."""
    front: DesignFront | None = None
    """The front, once it has ended."""
    failure: MessageData | None = None
    """Why it failed, or null."""


@document
class DesignRunNow:
    """An event of a run."""

    id: str
    """Identifier of the run."""
    state: RunState
    """As in the run."""
    progress: DesignProgress
    """How far it is."""


@document
class DesignStudyVersion:
    """A version of a study that is kept, as the history tells it."""

    version: int
    """Its number."""
    name: Name
    """The study's name then."""
    note: Text
    """What was worth knowing of it."""
    actor: Text
    """Who stored it."""
    at: datetime
    """When, UTC."""
    document: dict[str, Any]
    """The document then."""
