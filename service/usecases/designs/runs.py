"""Runs: optima and fronts of design documents that take their time, followed by all replicas, stopped by any.

A run is computed in a thread of the service that was asked. It writes how far it is beside the database's history;
anyone who wants it to stop says so there. What it found enters the history with the run.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from datetime import timedelta
from functools import partial
from typing import Any

from db.rows import DesignProgressRow, DesignRunRow, DesignStudyRow
from db.store import Store
from service.design import optimising
from service.design.registry import study_of
from service.errors import DrumtrueError, InvalidInput
from service.messages import Message
from service.model import design as told
from service.model.design_run import DesignProgress, DesignRun, DesignRunNow, DesignRunRequest
from service.model.message import message_data
from service.optimize.search import Progress
from service.runtime.background import Stopped
from service.runtime.context import AppContext, never, require
from service.usecases.designs import answers

BEAT_S = 0.5
"""So often a run writes how far it is, and looks whether it is to stop."""
LOST = timedelta(minutes=2)
"""A run that has not written for so long is not computed any more: no step takes a tenth of it."""
COMMIT_S, LOOK_S = 10.0, 0.02
"""How long a run waits for the unit of work that added it, and how often it looks."""


def start(work: AppContext, request: DesignRunRequest) -> DesignRun:
    """Begin a run. Raises NotFound, RefusedDesign, InvalidInput, or Unavailable where enough are running."""
    with work.read() as store:
        document, version = _document(store, request)
    if request.kind == "front":
        optimising.require_front(document)
    else:
        optimising.require_optimum(document, request.method)
    run = DesignRun(
        id=work.new_id(),
        state="running",
        request=request,
        document=document,
        study_version=version,
        created_at=work.now(),
        ended_at=None,
        progress=DesignProgress(steps=0, evaluations=0, seconds=0.0, value=None, unit=""),
    )
    # The thread outlives the request: it joins no unit of work, and nobody who hangs up ends it.
    alone = replace(work, joined=None, looking=None, gone=never, seen=None)
    with work.write() as store:
        store.add(DesignRunRow(id=run.id, study_id=request.study_id, created_at=run.created_at, run=run))
        store.flush()
        store.add(DesignProgressRow(design_run_id=run.id, beat_at=run.created_at, stop=False, progress=run.progress))
        # Within the unit: where no more are begun nothing is stored. The thread waits for the unit's end.
        work.background.start(run.id, partial(_run, alone, run))
    return run


def get(work: AppContext, run_id: str) -> DesignRun:
    """One run, as far as it is. Raises NotFound."""
    with work.read() as store:
        return _seen(work, store, require(store, DesignRunRow, run_id))


def now(work: AppContext, run_id: str) -> DesignRunNow:
    """How far a run is. Raises NotFound."""
    run = get(work, run_id)
    return DesignRunNow(id=run.id, state=run.state, progress=run.progress)


def find(work: AppContext, limit: int, offset: int, *, study_id: str | None = None) -> tuple[DesignRun, ...]:
    """Runs, newest first."""
    with work.read() as store:
        return tuple(_seen(work, store, row) for row in store.design_runs(limit, offset, study_id=study_id))


def stop(work: AppContext, run_id: str) -> DesignRun:
    """Ask a run to stop with what it has; one that has ended stays as it is. Raises NotFound."""
    with work.write() as store:
        row = require(store, DesignRunRow, run_id)
        progress = store.get(DesignProgressRow, run_id)
        if progress is not None:
            progress.stop = True
        work.background.stop(run_id)
        return _seen(work, store, row)


def _document(store: Store, request: DesignRunRequest) -> tuple[told.DesignDocument, int | None]:
    if (request.study_id is None) == (request.document is None):
        raise InvalidInput(Message("design_run_of_what"), field="document", value=request.study_id)
    if request.document is not None:
        return request.document, None
    study = require(store, DesignStudyRow, request.study_id or "").study
    return study.document, study.version


def _seen(work: AppContext, store: Store, row: DesignRunRow) -> DesignRun:
    run, progress = row.run, store.get(DesignProgressRow, row.id)
    if run.state != "running":
        return run
    if progress is None or work.now() - progress.beat_at > LOST:
        run = replace(run, state="interrupted")
    return run if progress is None else replace(run, progress=progress.progress)


# ---------------------------------------------------------------- in the thread
def _run(work: AppContext, run: DesignRun, stopped: Stopped) -> None:
    if not _is_stored(work, run.id):
        return
    watch = _Watch(work, run, stopped)
    found: dict[str, Any]
    try:
        found = _front(watch) if run.request.kind == "front" else _optimum(watch)
    except DrumtrueError as refused:
        found = {"state": "failed", "failure": message_data(refused.data)}
    except Exception:
        _end(watch, {"state": "failed", "failure": message_data(Message("design_run_failed"))})
        raise
    _end(watch, found)


def _is_stored(work: AppContext, run_id: str) -> bool:
    """Whether the unit of work that added the run has ended well; it may be under way still."""
    waiting = threading.Event()
    for _ in range(round(COMMIT_S / LOOK_S)):
        with work.read() as store:
            if store.get(DesignRunRow, run_id) is not None:
                return True
        waiting.wait(LOOK_S)
    return False


@dataclass
class _Watch:
    """What a run tells while it lasts. latest: the last step's number and evaluations."""

    work: AppContext
    run: DesignRun
    stopped: Stopped
    latest: tuple[int, int] = (0, 0)
    asked: bool = False

    def __post_init__(self) -> None:
        self.began = self.beat = self.work.monotonic()
        self.problem = study_of(self.run.document).problem(self.run.document)

    def stop(self) -> bool:
        """Whether the run is to stop."""
        self.asked = self.asked or self.stopped()
        return self.asked

    def step(self, number: int, evaluations: int, best: Progress | None = None) -> None:
        """After a step: write how far the run is, if it is time to."""
        self.latest = number, evaluations
        if self.work.monotonic() - self.beat < BEAT_S:
            return
        self.beat = self.work.monotonic()
        progress = self.progress(best)
        with self.work.write() as store:
            row = store.get(DesignProgressRow, self.run.id)
            if row is None:
                self.asked = True
                return
            row.progress, row.beat_at = progress, self.work.now()
            self.asked = self.asked or row.stop

    def progress(self, best: Progress | None = None) -> DesignProgress:
        """How far the run is."""
        value, unit = None, ""
        if best is not None and best.violation <= 0.0:
            document = self.problem.apply(best.x)
            found = study_of(document).simulate(document).value(self.problem.objective_name)
            value, unit = answers.in_unit(found, self.problem.objective_quantity, self.run.document)
        return DesignProgress(
            steps=self.latest[0],
            evaluations=self.latest[1],
            seconds=self.work.monotonic() - self.began,
            value=value,
            unit=unit,
        )


def _optimum(watch: _Watch) -> dict[str, Any]:
    asked, work = watch.run.request, watch.work
    found = optimising.optimise(
        watch.run.document,
        asked.method,
        asked.seed,
        asked.steps,
        stop=watch.stop,
        clock=work.monotonic,
        deadline_s=asked.time_limit_s,
        watch=lambda step: watch.step(step.number, step.evaluations, step),
    )
    result = found.result
    value, unit = answers.in_unit(found.value, found.quantity, watch.run.document)
    progress = DesignProgress(
        steps=result.steps,
        evaluations=result.evaluations,
        seconds=result.seconds,
        value=value if result.feasible else None,
        unit=unit,
    )
    state = "stopped" if result.status == "stopped" else "done"
    return {"state": state, "outcome": answers.outcome(found, watch.run.document), "progress": progress}


def _front(watch: _Watch) -> dict[str, Any]:
    asked, work = watch.run.request, watch.work
    found = optimising.front(
        watch.run.document,
        asked.points,
        asked.seed,
        ceiling=answers.ceiling(asked.ceiling),
        stop=watch.stop,
        clock=work.monotonic,
        deadline_s=asked.time_limit_s,
        watch=lambda point: watch.step(point.number, point.evaluations),
    )
    watch.latest = watch.latest[0], found.evaluations
    state = "stopped" if watch.asked else "done"
    return {"state": state, "front": answers.front_of(found), "progress": watch.progress()}


def _end(watch: _Watch, found: dict[str, Any]) -> None:
    run = replace(watch.run, **{"progress": watch.progress(), **found}, ended_at=watch.work.now())
    with watch.work.write() as store:
        row = require(store, DesignRunRow, run.id, lock=True)
        row.run = run
        progress = store.get(DesignProgressRow, run.id)
        if progress is not None:
            store.delete(progress)
