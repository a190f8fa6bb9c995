"""`drumtrue arrange`: one request for an arrangement in, its answer out, without a server."""

from __future__ import annotations

import json
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from pydantic import ValidationError

from service.messages import Message

if TYPE_CHECKING:
    from rich.console import Console

    from service.engine.arrangement import ArrangementContext
    from service.model.arrangement import ArrangementRequest


def arrange(
    file: Annotated[
        Path, typer.Argument(exists=True, dir_okay=False, help="A request as POST /arrangements takes it.")
    ],
    front: Annotated[bool, typer.Option("--front", help="The best arrangement for each number of moves.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")] = False,
) -> None:
    """Say which weighed part goes into which place, proved, without a server.

    A stored machine, session or box is not known here: state places, planes_axial_mm and the offset in the file.
    """
    from rich.console import Console

    from service.engine import arrangement
    from service.model.base import to_plain

    request, ground = _request(file)
    if front:
        points = arrangement.front(ground, request, time.monotonic)
        plain = [to_plain(point) for point in points]
        if as_json:
            print(json.dumps(plain, indent=2))
            return
        for point in plain:
            _show(Console(highlight=False), point["offer"], f"{point['moves']} moves")
        return
    answer = arrangement.answer(
        ground,
        request,
        key="file",
        machine_id=None,
        session_id=None,
        at=datetime.now(UTC),
        monotonic=time.monotonic,
    )
    plain_answer = to_plain(answer)
    if as_json:
        print(json.dumps(plain_answer, indent=2))
        return
    _show(Console(highlight=False), plain_answer, request.mode)


def _request(file: Path) -> tuple[ArrangementRequest, ArrangementContext]:
    """The request of a file. Raises InvalidInput for what is none, or needs what is stored."""
    from service.engine.arrangement import ArrangementContext
    from service.errors import InvalidInput
    from service.model.arrangement import ArrangementRequest
    from service.model.base import read_json

    try:
        request = read_json(ArrangementRequest, file.read_bytes())
    except ValidationError as wrong:
        first = wrong.errors(include_url=False, include_input=False)[0]
        field = ".".join(str(part) for part in first["loc"])
        raise InvalidInput(
            Message("not_a_request", file=file.name, field=field or "the file", rule=first["msg"]), field=field
        ) from None
    stored = ("machine_id", "session_id", "correction_id", "set", "catalogue_id")
    named = next((name for name in stored if getattr(request, name) is not None), None)
    if named is not None or request.places is None:
        raise InvalidInput(
            Message("needs_a_server", field=named or "places"),
            field=named or "places",
            value=None if named is None else getattr(request, named),
        )
    return request, ArrangementContext(request.places)


def _show(console: Console, answer: dict[str, Any], what: str) -> None:
    console.print(f"{what}: {answer['status']}, {answer['message']}", soft_wrap=True)
    if answer["reason"]:
        console.print(f"  {answer['reason']}", soft_wrap=True)
        return
    unit = answer.get("objective_unit", "")
    console.print(f"  objective {answer['objective_value']:.6g} {unit}, bound {answer['lower_bound']:.6g}")
    rule = answer.get("makers_rule")
    if rule:
        console.print(f"  the maker's rule would leave {rule['objective_value']:.6g} {unit}")
    for left in answer["residual"]:
        console.print(
            f"  left in plane {left['plane']}: {left['unbalance_g_mm']:.1f} g.mm @ {left['angle_deg']:.1f} deg"
        )
    if answer["moves"]:
        for number, move in enumerate(answer["moves"], start=1):
            console.print(f"  {number}. {move['part']}: {move['from'] or 'not mounted'} -> {move['to'] or 'off'}")
        return
    for one in answer["arrangement"]:
        console.print(f"  {one['place']}: {one['part'] or 'empty'}")
