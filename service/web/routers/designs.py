"""Design studies: listed, edited with a live check, optimised, traded off, taken over, reported."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Response
from fastapi.responses import HTMLResponse, JSONResponse

from service.design.documents import read_document
from service.design.findings import RefusedDesign
from service.design.registry import check as check_document
from service.errors import DrumtrueError, NotFound, Unavailable
from service.messages import Message
from service.model.design import DesignDocument, DesignEvaluation
from service.model.design_run import DesignRun, DesignRunRequest, DesignStudy, DesignStudyRequest, RunKind
from service.runtime.context import AppContext
from service.usecases.designs import answers, runs, studies
from service.web.designs import fields as form_fields
from service.web.designs import tables
from service.web.designs.figures import Figures, front_picture
from service.web.designs.names import METHODS, STATES, STUDIES, name_of
from service.web.designs.report import sheet_of
from service.web.form_guard import again, done
from service.web.forms import Form, TypedDep
from service.web.language import N_
from service.web.pictures.reader import Reader
from service.web.pictures.svg import to_svg
from service.web.rendering import Page, PageDep

router = APIRouter(prefix="/designs")
files = APIRouter()
"""The report as PDF: next to the page, and under the API's prefix too."""

MAX_LISTED = 100
MAX_RUNS = 10
TIME_LIMITS = {"10": 10.0, "60": 60.0, "600": 600.0, "3600": 3600.0}
POINTS = 60
MAX_TEXT = 20_000
Key = Annotated[str, Path(min_length=1, max_length=32, pattern="^[0-9A-Za-z_-]+$")]
KINDS: dict[str, RunKind] = {"optimum": "optimum", "front": "front"}


@router.get("")
def designs_page(page: PageDep) -> HTMLResponse:
    """Studies that are kept, the published systems, the latest runs."""
    return page.render(
        "designs/list.html",
        studies=studies.find(page.work, MAX_LISTED, 0),
        presets=answers.list_presets(),
        runs=runs.find(page.work, MAX_RUNS, 0),
        kinds=STUDIES,
        states=STATES,
    )


@router.get("/new")
def new_design(page: PageDep, name: Annotated[str, Query(max_length=100)] = "") -> HTMLResponse:
    """A published system as a form, or an empty place for a document of one's own."""
    document = answers.get_preset(name).document if name else None
    return _editor(
        page, _Edited(document, name=document["title"][:100] if document else ""), Form(None, page.preferences)
    )


@router.post("/new")
def keep_design(page: PageDep, typed: TypedDep) -> Response:
    """Keep a study, or show what is wrong with it."""
    form = Form(typed, page.preferences)
    document = _typed_document(form, _base(typed))
    return _kept(page, typed, form, document, None)


@router.post("/check")
def check_typed_design(page: PageDep, typed: TypedDep) -> JSONResponse:
    """What is wrong with the fields as they are typed: sentences by field; `general` for the rest."""
    form = Form(typed, page.preferences)
    document = _typed_document(form, _base(typed))
    found: dict[str, str] = dict(form.errors)
    if document is not None and form.ok:
        groups = form_fields.groups(form, document) if document.get("study") in STUDIES else ()
        for one in check_document(document):
            place = form_fields.place_of(one.field, groups)
            said = f"{page.message(one)}. {page.advice(one)}"
            found.setdefault(place, said)
    return JSONResponse({"fields": {name: text for name, text in found.items() if name}, "general": found.get("", "")})


@router.get("/runs/{run_id}")
def design_run_page(
    page: PageDep, run_id: Key, point: Annotated[int | None, Query(ge=0, le=1000)] = None
) -> HTMLResponse:
    """A run: how far it is; then what it found, next to the present design; a point of a front."""
    run = runs.get(page.work, run_id)
    return _run_page(page, run, point, Form(None, page.preferences))


@router.post("/runs/{run_id}/stop")
def stop_design_run_page(page: PageDep, typed: TypedDep, run_id: Key) -> Response:
    """Stop a run with what it has."""

    def stop(work: AppContext) -> str:
        return f"/designs/runs/{runs.stop(work, run_id).id}"

    return done(page, typed, stop)


@router.post("/runs/{run_id}/take")
def take_design(page: PageDep, typed: TypedDep, run_id: Key) -> Response:
    """Take what a run found over into its study as the next version, or keep it as a new one."""
    run = runs.get(page.work, run_id)
    form = Form(typed, page.preferences)
    point = form.whole("point", low=0, high=1000, required=False)
    found = _found(run, point)
    if found is None:
        raise NotFound(Message("design_run_without_answer"), field="run_id", value=run_id)
    note = page.text(N_("from a run of %(moment)s"), moment=f"{run.created_at:%Y-%m-%d %H:%M} UTC")

    def take(work: AppContext) -> str:
        if run.request.study_id is None:
            name = str(found.get("title") or found.get("study"))[:100]
            return f"/designs/{studies.create(work, DesignStudyRequest(name=name, document=found, note=note)).id}"
        study = studies.get(work, run.request.study_id)
        request = DesignStudyRequest(name=study.name, document=found, note=note)
        return f"/designs/{studies.change(work, study.id, request).id}"

    try:
        return done(page, typed, take)
    except DrumtrueError as error:
        form.refused(error)
        return _run_page(page, run, point, form, 422)


@files.get("/design-runs/{run_id}/report.pdf")
def get_design_report_pdf(page: PageDep, run_id: Key) -> Response:
    """The report of a run as PDF, in the language of the cookie or of Accept-Language."""
    from service.web.certificate.pdf import to_pdf

    run = runs.get(page.work, run_id)
    before = answers.evaluated(run.document)
    found = None if run.outcome is None else answers.evaluated(run.outcome.document)
    content = to_pdf(sheet_of(run, before, found, Reader(page.preferences)))
    headers = {
        "content-disposition": f'inline; filename="design-{run_id}.pdf"',
        "cache-control": "no-store",
        "x-content-type-options": "nosniff",
    }
    return Response(content, media_type="application/pdf", headers=headers)


@router.get("/{study_id}")
def design_page(page: PageDep, study_id: Key) -> HTMLResponse:
    """A study as a form, with what its design does, its versions and its runs."""
    return _editor(page, _Edited.of(studies.get(page.work, study_id)), Form(None, page.preferences))


@router.get("/{study_id}/versions/{version}")
def design_version_page(page: PageDep, study_id: Key, version: Annotated[int, Path(ge=1, le=10**9)]) -> HTMLResponse:
    """An earlier version of a study as a form; stored, it becomes the newest."""
    study = studies.get(page.work, study_id)
    told = studies.version(page.work, study_id, version)
    edited = replace(_Edited.of(study), document=told.document, name=told.name, note=told.note, looked_back=version)
    return _editor(page, edited, Form(None, page.preferences))


@router.post("/{study_id}")
def save_design(page: PageDep, typed: TypedDep, study_id: Key) -> Response:
    """Store the next version of a study, or show what is wrong with it."""
    study = studies.get(page.work, study_id)
    form = Form(typed, page.preferences)
    document = _typed_document(form, _base(typed) or study.document)
    return _kept(page, typed, form, document, study)


@router.post("/{study_id}/runs")
def run_design(page: PageDep, typed: TypedDep, study_id: Key) -> Response:
    """Begin an optimum or a front of a study."""
    form = Form(typed, page.preferences)
    study = studies.get(page.work, study_id)
    kind = form.choice("run_kind", KINDS) or "optimum"
    limit = form.choice("time_limit", TIME_LIMITS, required=False) or "60"
    method = form.value("method") or None
    request = DesignRunRequest(
        kind=KINDS[kind], study_id=study_id, method=method, points=POINTS, time_limit_s=TIME_LIMITS[limit]
    )
    try:
        return done(page, typed, lambda work: f"/designs/runs/{runs.start(work, request).id}")
    except Unavailable as busy:
        return again(page, typed, busy)
    except DrumtrueError as error:
        form.refused(error)
        return _editor(page, _Edited.of(study), form, 422)


# ---------------------------------------------------------------- the editor
@dataclass(frozen=True)
class _Edited:
    """What the editor shows: a document with or without a study that is kept."""

    document: DesignDocument | None
    name: str = ""
    note: str = ""
    study: DesignStudy | None = None
    looked_back: int | None = None

    @classmethod
    def of(cls, study: DesignStudy) -> _Edited:
        return cls(study.document, study.name, study.note, study)


def _editor(page: Page, edited: _Edited, form: Form, status: int = 200) -> HTMLResponse:
    document, study = edited.document, edited.study
    groups = form_fields.groups(form, document) if document is not None and document.get("study") in STUDIES else ()
    shown, figures = _shown(page, document, form)
    reader = Reader(page.preferences)
    return page.render(
        "designs/study.html",
        status=status,
        form=form,
        edited=edited,
        study=study,
        groups=groups,
        document_text="" if document is None else json.dumps(document, ensure_ascii=False),
        rows=() if shown is None else tables.rows(shown.responses, None, reader),
        broken=() if shown is None else tables.broken(shown.responses.limits, reader),
        warnings=() if shown is None else shown.responses.warnings,
        evaluated=shown is not None,
        pictures=[] if figures is None else [(kind, to_svg(one)) for kind, one in figures.all().items()],
        frames=_frames(figures),
        versions=() if study is None else studies.versions(page.work, study.id)[:MAX_RUNS],
        runs=() if study is None else runs.find(page.work, MAX_RUNS, 0, study_id=study.id),
        kinds=STUDIES,
        states=STATES,
        methods=_methods(document) if shown is not None else (),
        has_front=shown is not None and document is not None and answers.has_front(document),
        time_limits=TIME_LIMITS,
        method_names=METHODS,
        name_of=name_of,
    )


def _shown(page: Page, document: DesignDocument | None, form: Form) -> tuple[DesignEvaluation | None, Figures | None]:
    if document is None:
        return None, None
    try:
        shown = answers.evaluated(document)
    except RefusedDesign as refused:
        groups = form_fields.groups(form, document) if document.get("study") in STUDIES else ()
        for one in refused.findings:
            place = form_fields.place_of(one.field, groups)
            form.errors.setdefault(place, f"{page.message(one)}. {page.advice(one)}")
        return None, None
    return shown, Figures(shown, None, Reader(page.preferences))


def _methods(document: DesignDocument | None) -> tuple[str, ...]:
    return () if document is None else answers.methods(document)


def _frames(figures: Figures | None) -> str | None:
    scene = None if figures is None else figures.scene()
    return None if scene is None else json.dumps(scene.frames(), separators=(",", ":"))


def _kept(
    page: Page, typed: dict[str, str], form: Form, document: DesignDocument | None, study: DesignStudy | None
) -> Response:
    name = form.text("study_name", required=True)
    note = form.text("study_note", most=2000) or ""
    edited = _Edited(document, form.value("study_name"), note, study)
    if not form.ok or document is None or name is None:
        return _editor(page, edited, form, 422)
    request = DesignStudyRequest(name=name, document=document, note=note)

    def keep(work: AppContext) -> str:
        if study is None:
            return f"/designs/{studies.create(work, request).id}"
        seen = form.value("study_version")
        work = work.having_seen(int(seen) if seen.isdecimal() and len(seen) < 10 else None)
        return f"/designs/{studies.change(work, study.id, request).id}"

    try:
        return done(page, typed, keep)
    except RefusedDesign:
        return _editor(page, edited, form, 422)  # the faults are put beside their fields there
    except DrumtrueError as error:
        form.refused(error)
        return _editor(page, edited, form, 409 if error.status == 412 else 422)


def _base(typed: dict[str, str]) -> DesignDocument | None:
    """The document that the form was made from, as the page carried it."""
    try:
        found = json.loads(typed.get("base", "") or "null")
    except ValueError:
        return None
    return found if isinstance(found, dict) else None


def _typed_document(form: Form, base: DesignDocument | None) -> DesignDocument | None:
    """What was typed as a document: a whole one, or the fields put into the one that the page was made from."""
    whole = form.value("document").strip()
    try:
        if whole:
            return read_document(whole)
        if base is None:
            form.wrong("document", N_("Fill in this field."))
            return None
        return form_fields.typed_into(form, base)
    except DrumtrueError as error:
        show = Reader(form.preferences)
        form.errors.setdefault("document" if whole else "", f"{show.message(error)}. {show.advice(error)}")
        return None


# ---------------------------------------------------------------- runs
def _found(run: DesignRun, point: int | None) -> dict[str, Any] | None:
    """The document that a run found; of a front that of one of its points."""
    if run.outcome is not None:
        return run.outcome.document
    if run.front is not None and run.front.points:
        number = min(point or 0, len(run.front.points) - 1)
        return {**run.document, "design": run.front.points[number].design}
    return None


def _run_page(page: Page, run: DesignRun, point: int | None, form: Form, status: int = 200) -> HTMLResponse:
    reader = Reader(page.preferences)
    found = _found(run, point)
    before = answers.evaluated(run.document)
    after = None if found is None else answers.evaluated(found)
    figures = Figures(before if after is None else after, None if after is None else before, reader)
    front = run.front
    chosen = None if front is None or not front.points else min(point or 0, len(front.points) - 1)
    return page.render(
        "designs/run.html",
        status=status,
        form=form,
        run=run,
        study=None if run.request.study_id is None else studies.get(page.work, run.request.study_id),
        rows=tables.rows(before.responses, None if after is None else after.responses, reader),
        broken_before=tables.broken(before.responses.limits, reader),
        broken_after=() if after is None else tables.broken(after.responses.limits, reader),
        holding=() if after is None else tables.holding(after.responses.limits, reader),
        evidence=None if run.outcome is None else tables.evidence(run.outcome.evidence, reader),
        value=tables.value_of(run.progress.value, run.progress.unit, reader),
        pictures=[(kind, to_svg(one)) for kind, one in figures.all().items()],
        frames=_frames(figures) if after is not None else None,
        front=None if front is None or not front.points else to_svg(front_picture(front, reader, chosen)),
        points=() if front is None else tables.points(front, reader),
        chosen=chosen,
        states=STATES,
        method_names=METHODS,
        name_of=name_of,
        after=after,
    )


pages = APIRouter()
pages.include_router(router)
pages.include_router(files)
