"""The report of a session: as a page, as a certificate in PDF, as JSON and CSV."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Response
from fastapi.responses import HTMLResponse, RedirectResponse

from service.usecases.sessions import reports, sessions
from service.usecases.sessions.report_rows import report_csv
from service.web.certificate.content import certificate
from service.web.certificate.document import Sheet
from service.web.pictures.reader import Reader
from service.web.pictures.svg import to_svg
from service.web.rendering import PageDep

router = APIRouter()
files = APIRouter()
"""PDF and CSV: beside the page, and under the API's prefix too."""

Key = Annotated[str, Path(min_length=1, max_length=32, pattern="^[0-9A-Za-z_-]+$")]


@router.get("/sessions/{session_id}/report")
def show_report(page: PageDep, session_id: Key) -> HTMLResponse:
    """The certificate as a page that prints well."""
    return page.render("report.html", sheet=_sheet(page, session_id), session_id=session_id, svg=to_svg)


@router.get("/sessions/{session_id}/report.json")
def show_report_json(session_id: Key) -> RedirectResponse:
    """The report as the API gives it."""
    return RedirectResponse(f"/api/v1/sessions/{session_id}/report.json", status_code=307)


@files.get("/sessions/{session_id}/report.pdf")
def get_report_pdf(page: PageDep, session_id: Key) -> Response:
    """The certificate as PDF, in the language and units of the cookie or of Accept-Language."""
    from service.web.certificate.pdf import to_pdf

    return file_answer(to_pdf(_sheet(page, session_id)), "application/pdf", f"certificate-{session_id}.pdf")


@files.get("/sessions/{session_id}/report.csv")
def get_report_csv(page: PageDep, session_id: Key) -> Response:
    """The report as a table for a spreadsheet, in the units it is stored in."""
    text = report_csv(sessions.get(page.work, session_id), reports.report(page.work, session_id))
    return file_answer(text.encode("utf-8-sig"), "text/csv; charset=utf-8", f"report-{session_id}.csv")


def _sheet(page: PageDep, session_id: str) -> Sheet:
    session = sessions.get(page.work, session_id)
    return certificate(session, reports.report(page.work, session_id), Reader(page.preferences))


def file_answer(content: bytes, media_type: str, name: str) -> Response:
    """A file that the browser shows, and does not keep."""
    headers = {
        "content-disposition": f'inline; filename="{name}"',
        "cache-control": "no-store",
        "x-content-type-options": "nosniff",
    }
    return Response(content, media_type=media_type, headers=headers)


router.include_router(files)
