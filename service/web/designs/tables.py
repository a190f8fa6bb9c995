"""Responses and limits of designs as rows and sentences."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from service.model.design import DesignEvidence, DesignFront, DesignLimit, DesignResponses
from service.web.designs.names import LIMITS, RESPONSES, name_of
from service.web.language import N_
from service.web.pictures.designs.axes import figure
from service.web.pictures.reader import Reader


@dataclass(frozen=True)
class Row:
    """A response before and after, as text; after is empty where there is one design alone."""

    name: str
    before: str
    after: str
    change: str


def rows(before: DesignResponses, after: DesignResponses | None, reader: Reader) -> tuple[Row, ...]:
    """Every response of one design, or of two next to each other."""
    later = {} if after is None else {one.name: one for one in after.scalars}
    out = []
    for one in before.scalars:
        new = later.get(one.name)
        change = ""
        if new is not None and one.value and new.value is not None and len(one.unit) < 12:
            change = f"{reader.signed(100.0 * (new.value - one.value) / abs(one.value))} %"
        out.append(
            Row(
                name_of(RESPONSES, one.name, reader.gettext),
                value_of(one.value, one.unit, reader),
                "" if new is None else value_of(new.value, new.unit, reader),
                change,
            )
        )
    return tuple(out)


def value_of(value: float | None, unit: str, reader: Reader) -> str:
    """A number with its unit."""
    if value is None:
        return "\N{EM DASH}"
    return f"{reader.show.figure(f'{value:.6g}')} {unit.replace('um', 'µm')}".strip()


def broken(limits: Iterable[DesignLimit], reader: Reader) -> tuple[str, ...]:
    """Each limit that is broken, as text."""
    return tuple(_broken(one, reader) for one in limits if one.violated)


def holding(limits: Iterable[DesignLimit], reader: Reader) -> tuple[str, ...]:
    """Names of the limits that hold a design back."""
    return tuple(_named(one, reader) for one in limits if one.active and not one.violated)


def _broken(one: DesignLimit, reader: Reader) -> str:
    text = (
        N_("%(limit)s: at most %(most)s is allowed, this design has %(value)s")
        if one.sense == "at_most"
        else N_("%(limit)s: at least %(most)s is needed, this design has %(value)s")
    )
    return reader.gettext(text) % {
        "limit": _named(one, reader),
        "most": value_of(one.limit, one.unit, reader),
        "value": value_of(one.value, one.unit, reader),
    }


def _named(one: DesignLimit, reader: Reader) -> str:
    name = name_of(LIMITS, one.code, reader.gettext)
    return f"{name} ({one.where})" if one.where else name


def evidence(found: DesignEvidence, reader: Reader) -> str:
    """What speaks for an answer, as a sentence."""
    _ = reader.gettext
    if found.kind == "proved_bound":
        return _("Proved: no design within the limits is better than the bound %(bound)s.") % {
            "bound": "" if found.bound is None else figure(found.bound, reader)
        }
    agreeing = (
        _("%(agreeing)s of %(starts)s starts ended in it.") % {"agreeing": found.agreeing, "starts": found.starts}
        if found.agreeing
        else ""
    )
    if found.kind == "kkt" and found.residual is not None:
        residual = reader.show.figure(f"{found.residual:.0e}")
        said = _("The conditions of an optimum hold to %(residual)s; it is the best found, not proved.")
        return f"{said % {'residual': residual}} {agreeing}".strip()
    return agreeing or _("The best found, without proof.")


def points(front: DesignFront, reader: Reader) -> tuple[tuple[str, str], ...]:
    """Both responses of each point of a front."""
    return tuple((figure(one.first, reader), figure(one.second, reader)) for one in front.points)
