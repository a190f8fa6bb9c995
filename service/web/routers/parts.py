"""Parts of a machine: sets of places described, parts weighed, one that broke, and what is asked of all of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, TypeVar
from urllib.parse import quote

from fastapi import APIRouter, Depends, Path
from fastapi.responses import HTMLResponse, Response
from pydantic import ValidationError

from service.errors import DrumtrueError, NotFound, Unavailable
from service.messages import Message
from service.model.arrangement import ArrangementRequest
from service.model.base import read_json, write_json
from service.model.machine import StoredMachine
from service.model.parts import PartRecord, PlaceSet, PlaceSetRequest, WeighRequest
from service.runtime.context import AppContext
from service.usecases.arrangements import arrangements, parts, place_sets
from service.usecases.machines import machines
from service.usecases.stock import catalogues
from service.web.form_guard import again, done
from service.web.forms import Form, TypedDep
from service.web.parts import asked, scale, set_form, views
from service.web.pictures.reader import Reader
from service.web.pictures.svg import to_svg
from service.web.rendering import Page, PageDep

router = APIRouter(prefix="/machines/{machine_id}/parts")

MAX_EVENTS, MAX_ARRANGEMENTS, MAX_BOXES = 60, 10, 50
Key = Annotated[str, Path(min_length=1, max_length=32, pattern="^[0-9A-Za-z_-]+$")]
SetName = Annotated[str, Path(min_length=1, max_length=100)]
SCALE_G = "1"
FEW_MOVES = "3"
T = TypeVar("T")


@dataclass(frozen=True)
class Bench:
    """A machine's set of places, with the parts that belong to it."""

    machine: StoredMachine
    found: PlaceSet
    records: tuple[PartRecord, ...]
    taken: set[str]
    """Numbers of all parts of the machine."""

    @property
    def path(self) -> str:
        """The address of its page."""
        return address(self.machine.id, self.found.name)


def address(machine_id: str, name: str) -> str:
    """Where the page of a set of places is."""
    return f"/machines/{machine_id}/parts/{quote(name, safe='')}"


def _bench(page: PageDep, machine_id: Key, name: SetName) -> Bench:
    machine = machines.get(page.work, machine_id)
    sets = place_sets.find(page.work, machine_id)
    found = next((one for one in sets if one.name == name), None)
    if found is None:
        raise NotFound(Message("place_set_not_found", name=name), field="set", value=name)
    every = parts.current(page.work, machine_id)
    return Bench(machine, found, parts.of_set(every, sets, name), {one.part for one in every})


BenchDep = Annotated[Bench, Depends(_bench)]


@router.get("/new")
def new_set(page: PageDep, machine_id: Key) -> HTMLResponse:
    """An empty form of a set of places."""
    machine = machines.get(page.work, machine_id)
    return _set_form(page, machine, set_form.blank(page))


@router.post("/new")
def store_set(page: PageDep, typed: TypedDep, machine_id: Key) -> Response:
    """Store a set of places; one of the same name is described anew."""
    machine, form = machines.get(page.work, machine_id), Form(typed, page.preferences)
    described = set_form.read(page, form)
    if described is not None:
        name, places = described
        request = PlaceSetRequest(places=places)

        def put(work: AppContext) -> str:
            place_sets.put(work, machine_id, name, request)
            return address(machine_id, name)

        try:
            return done(page, typed, put)
        except DrumtrueError as error:
            form.refused(error)
    return _set_form(page, machine, form, 422)


@router.get("/{name}")
def set_page(page: PageDep, bench: BenchDep) -> HTMLResponse:
    """A set of places: what is in each, spare parts, arrangements, history."""
    events = parts.history(page.work, bench.machine.id, None, MAX_EVENTS, 0)
    labels = {one.part for one in bench.records}
    made = arrangements.find(page.work, MAX_ARRANGEMENTS, 0, machine_id=bench.machine.id)
    return page.render(
        "parts/set.html",
        bench=bench,
        inside=scale.in_places(bench.records),
        spares=[one for one in bench.records if one.place is None],
        arrangements=[one for one in made if one.request.set in (bench.found.name, None)],
        events=[one for one in events if one.part in labels],
        pictures=_pictures(page, bench),
        mass=views.mass,
        next_place=scale.first_to_weigh(bench.found.places, bench.records),
    )


@router.get("/{name}/weigh")
def weigh_page(page: PageDep, bench: BenchDep, place: str | None = None) -> HTMLResponse:
    """The part of one place, or a spare one, on the scale."""
    label = scale.first_to_weigh(bench.found.places, bench.records) if place is None else place
    form = scale.blank(page, label, scale.in_places(bench.records).get(label), bench.taken)
    return _weigh(page, bench, label, form)


@router.post("/{name}/weigh")
def store_weighing(page: PageDep, typed: TypedDep, bench: BenchDep) -> Response:
    """Write down what the scale says, and go on to the next place."""
    form, label = Form(typed, page.preferences), typed.get("place", scale.SPARE)
    read = scale.read(page, form, bench.found, label)
    if read is not None:
        request = WeighRequest(place_set=bench.found.name, parts=(read,))
        after = scale.following(bench.found.places, label)

        def write(work: AppContext) -> str:
            parts.weigh(work, bench.machine.id, _checked(WeighRequest, request))
            return bench.path if after is None else f"{bench.path}/weigh?place={quote(after)}"

        try:
            return done(page, typed, write)
        except (DrumtrueError, ValidationError) as error:
            _refused(page, form, error)
    return _weigh(page, bench, label, form, 422)


@router.get("/{name}/arrange")
def ask_page(page: PageDep, bench: BenchDep) -> HTMLResponse:
    """The form that asks which part goes where."""
    bases = asked.measured_with(page.work, bench.machine)
    start = {
        "offset": asked.starts(bases, bench.records, bench.found.places),
        "mode": "best",
        "use": "parts",
        "scale_resolution_g": SCALE_G,
    }
    start |= {f"use[{n}]": "yes" for n, one in enumerate(bench.records) if one.place is None and one.event == "weighed"}
    return _ask(page, bench, Form(start, page.preferences))


@router.post("/{name}/arrange")
def ask(page: PageDep, typed: TypedDep, bench: BenchDep) -> Response:
    """Arrange the parts."""
    form = Form(typed, page.preferences)
    request = asked.read(page, form, bench.machine, bench.found, bench.records)
    if request is not None:
        answer = _proposed(page, typed, form, request)
        if answer is not None:
            return answer
    return _ask(page, bench, form, 422)


@router.get("/{name}/broke")
def broke_page(page: PageDep, bench: BenchDep, place: str | None = None) -> HTMLResponse:
    """One part broke: which one, and what goes in instead."""
    form = Form({"max_moves": FEW_MOVES, "scale_resolution_g": SCALE_G}, page.preferences)
    return _broke(page, bench, place, form)


@router.post("/{name}/broke")
def one_broke(page: PageDep, typed: TypedDep, bench: BenchDep) -> Response:
    """Arrange the parts anew with one replaced, with few moves."""
    form = Form(typed, page.preferences)
    inside = scale.in_places(bench.records)
    place = next((one for one in bench.found.places if one.label == typed.get("place") and one.label in inside), None)
    if place is None:
        return _broke(page, bench, None, form, 422)
    request = asked.broken(page, form, bench.machine, bench.found, bench.records, place)
    if request is not None:
        answer = _proposed(page, typed, form, request)
        if answer is not None:
            return answer
    return _broke(page, bench, place.label, form, 422)


def _proposed(page: Page, typed: dict[str, str], form: Form, request: ArrangementRequest) -> Response | None:
    """The way on to the arrangement; None where the form is refused."""

    def propose(work: AppContext) -> str:
        return f"/arrangements/{arrangements.propose(work, _checked(ArrangementRequest, request)).id}"

    try:
        return done(page, typed, propose)
    except Unavailable as busy:
        return again(page, typed, busy)
    except (DrumtrueError, ValidationError) as error:
        _refused(page, form, error)
        return None


def _refused(page: Page, form: Form, error: DrumtrueError | ValidationError) -> None:
    if isinstance(error, DrumtrueError):
        # Fields of the form are named otherwise than those of the document.
        told = " ".join(f"{text.rstrip('.')}." for text in (page.message(error), page.advice(error)) if text)
        form.errors.setdefault("", told)
        return
    form.errors.setdefault("", page.words(str(error.errors()[0]["msg"])))


def _checked(kind: type[T], document: T) -> T:
    """A document once its fields keep their rules: one made in code is not checked by itself."""
    return read_json(kind, write_json(document))


def _pictures(page: Page, bench: Bench) -> list[Any]:
    drawn = views.pictures(bench.machine, views.present(bench.found.places, bench.records), Reader(page.preferences))
    return [to_svg(one) for one in drawn]


def _set_form(page: Page, machine: StoredMachine, form: Form, status: int = 200) -> HTMLResponse:
    return page.render("parts/set_form.html", status=status, machine=machine, form=form, kinds=set_form.KINDS)


def _weigh(page: Page, bench: Bench, label: str, form: Form, status: int = 200) -> HTMLResponse:
    return page.render(
        "parts/weigh.html",
        status=status,
        bench=bench,
        form=form,
        place=label,
        ends=scale.ends_of(bench.found, label),
        kinds=sorted({place.kind for place in bench.found.places if place.kind is not None}),
        inside=scale.in_places(bench.records),
        following=scale.following(bench.found.places, label),
        mass=views.mass,
        weighed=scale.weighed,
    )


def _ask(page: Page, bench: Bench, form: Form, status: int = 200) -> HTMLResponse:
    return page.render(
        "parts/arrange.html",
        status=status,
        bench=bench,
        form=form,
        bases=asked.measured_with(page.work, bench.machine),
        boxes=catalogues.find(page.work, MAX_BOXES, 0),
        aims=asked.AIMS,
        uses=asked.USES,
        mass=views.mass,
        weighed=scale.weighed,
    )


def _broke(page: Page, bench: Bench, label: str | None, form: Form, status: int = 200) -> HTMLResponse:
    inside = scale.in_places(bench.records)
    return page.render(
        "parts/broke.html",
        status=status,
        bench=bench,
        form=form,
        place=label if label in inside else None,
        inside=inside,
        ends=scale.ends_of(bench.found, label or ""),
        mass=views.mass,
        weighed=scale.weighed,
    )
