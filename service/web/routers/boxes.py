"""Boxes of stock masses: what is in them, what was put in, what a count found."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path
from fastapi.responses import HTMLResponse, Response

from service.errors import DrumtrueError
from service.model.machine import Catalogue, CatalogueItem, CataloguePatch, Pieces
from service.usecases.stock import catalogues
from service.web.form_guard import done
from service.web.forms import Form, TypedDep
from service.web.language import N_
from service.web.rendering import Page, PageDep

router = APIRouter(prefix="/boxes")

MAX_LISTED = 200
ROWS, MAX_ROWS = 6, 60
MAX_PIECES = 1_000_000
MAX_MOVEMENTS = 50
"""Entries of the ledger that are shown, the newest."""
Key = Annotated[str, Path(min_length=1, max_length=32, pattern="^[0-9A-Za-z_-]+$")]


@router.get("")
def boxes_page(page: PageDep) -> HTMLResponse:
    """All boxes with what is left in each."""
    return page.render("boxes.html", boxes=catalogues.find(page.work, MAX_LISTED, 0))


@router.get("/new")
def new_box(page: PageDep) -> HTMLResponse:
    """An empty form."""
    return _form(page, Form({"rows": str(ROWS)}, page.preferences))


@router.post("/new")
def store_box(page: PageDep, typed: TypedDep) -> Response:
    """Store a box, or show the form again with more lines."""
    form = Form(typed, page.preferences)
    if form.value("more"):
        form.values["rows"] = str(min(_rows(form) + ROWS, MAX_ROWS))
        return _form(page, form)
    name = form.text("name", required=True)
    items = tuple(item for index in range(_rows(form)) if (item := _item(page, form, index)) is not None)
    if form.ok and not items:
        form.wrong("items[0].mass_g", N_("Fill in this field."))
    if form.ok and name is not None:
        try:
            box = Catalogue(name=name, items=items)
            return done(page, typed, lambda work: f"/boxes/{catalogues.create(work, box).id}")
        except DrumtrueError as error:
            form.refused(error)
    return _form(page, form, 422)


@router.get("/{box_id}")
def box_page(page: PageDep, box_id: Key) -> HTMLResponse:
    """One box: what is left, and where a count or a delivery is booked."""
    return _box(page, box_id, Form(preferences=page.preferences))


@router.post("/{box_id}")
def book_box(page: PageDep, typed: TypedDep, box_id: Key) -> Response:
    """Book pieces put in, or what a count found."""
    form = Form(typed, page.preferences)
    box = catalogues.get(page.work, box_id)
    received, counted = [], []
    for index, item in enumerate(box.items):
        put_in = form.whole(f"received[{index}]", low=0, high=MAX_PIECES, required=False)
        found = form.whole(f"counted[{index}]", low=0, high=MAX_PIECES, required=False)
        if put_in:
            received.append(Pieces(mass_g=item.mass_g, pieces=put_in))
        if found is not None:
            counted.append(Pieces(mass_g=item.mass_g, pieces=found))
    if form.ok:
        try:
            patch = CataloguePatch(received=tuple(received), counted=tuple(counted))
            return done(page, typed, lambda work: f"/boxes/{catalogues.change(work, box_id, patch).id}")
        except DrumtrueError as error:
            form.refused(error)
    return _box(page, box_id, form, 422)


def _rows(form: Form) -> int:
    text = form.value("rows", str(ROWS))
    return min(int(text), MAX_ROWS) if text.isdecimal() and len(text) < 4 else ROWS


def _item(page: Page, form: Form, index: int) -> CatalogueItem | None:
    """One line of the form; an empty one is none."""
    where, unit = f"items[{index}]", page.display.mass_unit()
    names = (f"{where}.mass_g", f"{where}.count", f"{where}.name")
    if not any(form.value(name).strip() for name in names):
        return None
    grams = form.number(f"{where}.mass_g", above=0.0, high=1e6, unit=unit)
    pieces = form.whole(f"{where}.count", low=1, high=MAX_PIECES, required=False)
    fastener = form.number(f"{where}.fastener_g", low=0.0, high=1e5, unit=unit, required=False)
    name = form.text(f"{where}.name")
    return None if grams is None else CatalogueItem(mass_g=grams, count=pieces, name=name, fastener_g=fastener or 0.0)


def _form(page: Page, form: Form, status: int = 200) -> HTMLResponse:
    return page.render("box_form.html", status=status, form=form, rows=_rows(form))


def _box(page: Page, box_id: str, form: Form, status: int = 200) -> HTMLResponse:
    stock = catalogues.stock_of(page.work, box_id, MAX_MOVEMENTS, 0)
    return page.render("box.html", status=status, form=form, box=catalogues.get(page.work, box_id), stock=stock)
