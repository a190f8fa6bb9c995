"""A machine over its sessions."""

from __future__ import annotations

from markupsafe import Markup

from service.engine.mapping import Channel, limit_of
from service.model.machine import StoredMachine
from service.usecases.sessions import reports
from service.web.pictures.reader import Reader
from service.web.pictures.svg import to_svg
from service.web.pictures.trend import TrendPoint, trend_chart
from service.web.rendering import Page

MAX_SESSIONS = 12
"""This many are read for a trend: a page stays quick however long a machine has been looked after."""


def of_machine(page: Page, machine: StoredMachine) -> list[Markup]:
    """A picture for each sensor that was measured at service speed in two sessions or more, with the limit."""
    points: dict[str, list[TrendPoint]] = {sensor.name: [] for sensor in machine.sensors}
    sensors = {sensor.name: sensor for sensor in machine.sensors}
    for opened_at, lines in reports.trend(page.work, machine.id, MAX_SESSIONS):
        for line in lines:
            if line.sensor in points and line.speed_rpm == machine.service_speed_rpm:
                unit = page.display.amplitude_unit(sensors[line.sensor])
                after = None if line.after is None else unit.show(line.after)
                points[line.sensor].append(TrendPoint(opened_at, unit.show(line.before), after))
    reader = Reader(page.preferences)
    out = []
    for name, found in points.items():
        if len(found) > 1:
            unit = page.display.amplitude_unit(sensors[name])
            limit = limit_of(machine, Channel(sensors[name], machine.service_speed_rpm))
            shown = None if limit is None else unit.show(limit)
            out.append(to_svg(trend_chart(found, name, page.text(unit.sign), reader, limit=shown)))
    return out
