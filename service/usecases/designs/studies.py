"""Design studies that are kept: stored, changed version by version, looked at as they were."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from db.rows import AuditRow, DesignStudyRow
from db.store import Store
from service.design.registry import study_of
from service.errors import NotFound, Stale
from service.messages import Message, Word
from service.model.design import DesignDocument
from service.model.design_run import DesignStudy, DesignStudyRequest, DesignStudyVersion
from service.runtime.context import AppContext, require

_KIND = DesignStudyRow.__tablename__
_PAGE = 200
_TOLD = frozenset({"name", "note", "document", "version"})
"""Fields of a study that a version has."""


def create(work: AppContext, request: DesignStudyRequest) -> DesignStudy:
    """Keep a study. Raises RefusedDesign for a document that breaks a rule."""
    kind = _accepted(request.document)
    now = work.now()
    study = DesignStudy(
        id=work.new_id(),
        name=request.name,
        study=kind,
        version=1,
        note=request.note,
        document=request.document,
        created_at=now,
        updated_at=now,
    )
    with work.write() as store:
        store.add(DesignStudyRow(id=study.id, created_at=now, updated_at=now, study=study))
    return study


def get(work: AppContext, study_id: str) -> DesignStudy:
    """One study as it stands. Raises NotFound."""
    with work.read() as store:
        return require(store, DesignStudyRow, study_id).study


def find(work: AppContext, limit: int, offset: int) -> tuple[DesignStudy, ...]:
    """Studies, the one changed last first."""
    with work.read() as store:
        return tuple(row.study for row in store.design_studies(limit, offset))


def change(work: AppContext, study_id: str, request: DesignStudyRequest) -> DesignStudy:
    """Store the next version of a study; the same again changes nothing.

    Raises NotFound, RefusedDesign, or Stale where the request was made on another version.
    """
    kind = _accepted(request.document)
    with work.write() as store:
        row = require(store, DesignStudyRow, study_id, lock=True)
        old = row.study
        if work.seen not in (None, old.version):
            raise Stale(
                Message("version_stale", noun=Word("design_study"), version=old.version, seen=work.seen),
                field="If-Match",
                value=work.seen,
                current=old,
            )
        told = {"name": request.name, "note": request.note, "document": request.document, "study": kind}
        if all(getattr(old, name) == value for name, value in told.items()):
            return old
        row.updated_at = work.now()
        row.study = replace(old, **told, version=old.version + 1, updated_at=row.updated_at)  # type: ignore[arg-type]
        return row.study


def versions(work: AppContext, study_id: str) -> tuple[DesignStudyVersion, ...]:
    """Every version of a study, the newest first, as the history tells them. Raises NotFound."""
    with work.read() as store:
        study = require(store, DesignStudyRow, study_id).study
        return tuple(_told(study, store))


def version(work: AppContext, study_id: str, number: int) -> DesignStudyVersion:
    """A study as it was at a version. Raises NotFound."""
    found = next((one for one in versions(work, study_id) if one.version == number), None)
    if found is None:
        raise NotFound(Message("design_version_not_found", value=number), field="version", value=number)
    return found


def _told(study: DesignStudy, store: Store) -> Iterator[DesignStudyVersion]:
    """From the study as it stands back to the first: each line of the history holds what it changed from and to."""
    offset = 0
    while lines := store.history(_PAGE, offset, kind=_KIND, key=study.id):
        for line in lines:
            yield _version(study, line)
            before = {
                name.removeprefix("study."): values[0]
                for name, values in line.changes.items()
                if name.startswith("study.") and isinstance(values, list)
            }
            study = replace(study, **{name: before[name] for name in _TOLD & before.keys()})
        offset += len(lines)


def _version(study: DesignStudy, line: AuditRow) -> DesignStudyVersion:
    return DesignStudyVersion(
        version=study.version, name=study.name, note=study.note, actor=line.actor, at=line.at, document=study.document
    )


def _accepted(document: DesignDocument) -> str:
    """Kind of study of a document that breaks no rule; a document that is refused is not kept."""
    study = study_of(document)
    study.simulate(document)
    return study.name
