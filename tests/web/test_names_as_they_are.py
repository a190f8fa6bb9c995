"""Names that users gave are shown as they are: no language translates them, no unit converts what stands in them.

A session is walked through twice, once with plain names, once with names that look like words, values, placeholders or
markup. Every page, certificate and refusal must be the same text, once the plain names in it are replaced.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest

from service.usecases.sessions import reports, sessions
from service.web.certificate.content import certificate
from service.web.pictures.reader import Reader
from service.web.preferences import COOKIE, Preferences
from tests.support.http.workshop import DRUM, LinearDrum, Workshop, machine_body, mass, workshop
from tests.support.storage.engines import Engine

READERS = (
    Preferences(mass="oz", length="in", velocity="in/s"),
    Preferences(language="de", mass="oz", length="in"),
)


@dataclass(frozen=True)
class Names:
    """Names of one session. All sets have the same lengths: a picture shortens a long name."""

    machine: str
    box: str
    technician: str
    source: str
    sensor_p: str
    sensor_q: str
    plane_1: str
    plane_2: str
    hole: str

    def drum(self) -> LinearDrum:
        sensors, planes = {"P": self.sensor_p, "Q": self.sensor_q}, {"1": self.plane_1, "2": self.plane_2}
        return LinearDrum(
            {sensors[name]: vector for name, vector in DRUM.initial.items()},
            {(sensors[s], planes[p]): vector for (s, p), vector in DRUM.influence.items()},
        )


PLAIN = Names("Qaaaaaaaa", "Qbbbbbbbb", "Qcccccccc", "Qdddddddd", "Qeeeeeeeeee", "Qfffff", "Qgggg", "Qhhhhhh", "Q k")
ODD = {
    "words, values and placeholders": Names(
        "open 10 g", "50 % {0}s", "the check", "%(count)s", "pickup 5 mm", "fitted", "trial", "{plane}", "5 g"
    ),
    "markup, quotes and Hebrew": Names(
        "<b>'\"x</b", "&amp; &lt", "טכנאי 1.5", "a\\'b\"c<>&", "</script>..", "\"'`<>&", "ניסוי", "&#39;>\\", '< "'
    ),
}


@contextmanager
def fresh(engine: Engine, folder: Path) -> Iterator[Workshop]:
    """A workshop over an empty database: identifiers and times are the same in each."""
    folder.mkdir()
    url = engine.migrated(folder)
    with workshop(url) as opened:
        yield opened
    engine.drop(url)


def walked(shop: Workshop, names: Names) -> dict[str, str]:
    """Text of everything that is shown of a session, by reader and address, at two moments and of refusals."""
    machine, box, key = opened(shop, names)
    drum = names.drum()
    seen: dict[str, str] = {}
    shop.run(key, "initial", drum=drum)
    shop.run(key, "trial", [mass(names.plane_1, 2000.0, 20.0)], drum)
    shop.run(key, "trial", [mass(names.plane_1, 1.0, 20.0)], drum)
    seen |= refusals(shop, key, names)
    shop.run(key, "trial", [mass(names.plane_2, 200.0, 40.0)], drum)
    correction = shop.correct(key)
    shop.plan(key, correction, mode="fewest", limit=1e-6, blocked=[{"plane": names.plane_1, "position_deg": 20.0}])
    seen |= shown(shop, "infeasible", [f"/sessions/{key}/step/plan", f"/sessions/{key}/step/correction"])
    plan = shop.plan(key, correction)
    shop.fit(plan)
    after = [mass(p["plane"], p["mass_g"], p["position_deg"]) for p in plan["placements"]]
    shop.run(key, "check", after, LinearDrum({n: 3.0 * v for n, v in drum.initial.items()}, drum.influence))
    pages = [
        *("/", "/sessions", "/sessions/new", "/machines", "/boxes", "/sources"),
        *(f"/machines/{machine}", f"/machines/{machine}/edit", f"/boxes/{box}"),
        *(f"/sessions/{key}{part}" for part in ("", "/runs", "/report", f"/plans/{plan['id']}/front")),
        *(f"/sessions/{key}/step/{step}" for step in ("trial", "correction", "plan", "fit", "check")),
    ]
    seen |= shown(shop, "checked", pages)
    session, report = sessions.get(shop.work, key), reports.report(shop.work, key)
    for reader in READERS:
        sheet = certificate(session, report, Reader(reader))
        seen[f"certificate {reader}"] = "\n".join(sheet.texts())
    return seen


def opened(shop: Workshop, names: Names) -> tuple[str, str, str]:
    """Machine, box and session of these names, with a source whose clock is ahead."""
    plane = {"radius_mm": 330.0, "positions_deg": [20.0, 40.0, 160.0, 280.0], "max_masses": 3}
    labels = [names.hole, "2", "3", "4"]
    body: dict[str, Any] = {
        "name": names.machine,
        "planes": [
            {"name": names.plane_1, "axial_mm": -330.0, **plane, "hole_labels": labels},
            {"name": names.plane_2, "axial_mm": 330.0, **plane},
        ],
        "sensors": [{"name": names.sensor_p, "axial_mm": -480.0}, {"name": names.sensor_q, "axial_mm": 440.0}],
    }
    machine = str(shop.post("/machines", machine_body(**body))["id"])
    box = str(shop.post("/catalogues", {"name": names.box, "items": [{"mass_g": 200.0, "count": 2}]})["id"])
    key = shop.session(machine, box, technician=names.technician)
    shop.ask("PUT", "/sources/" + quote(names.source, safe=""), {"machine_id": machine})
    ahead = {"source": names.source, "sequence": 1, "taken_at": "2031-01-01T00:00:00Z", "sensor": names.sensor_p}
    shop.post("/readings", [{**ahead, "amplitude": 3.0, "phase_deg": 10.0}])
    return machine, box, key


def refusals(shop: Workshop, key: str, names: Names) -> dict[str, str]:
    """What the API says of requests that cannot be: each names a name."""
    asked: dict[str, tuple[str, str, Any]] = {
        "dead sensor": ("POST", f"/sessions/{key}/corrections", {"source": "fit"}),
        "no such plane": ("POST", f"/sessions/{key}/runs", run_with([mass(names.machine, 1.0, 0.0)], names)),
        "sensor twice": ("POST", f"/sessions/{key}/runs", run_with([], names, names.sensor_p, names.sensor_p)),
        "name taken": ("POST", "/catalogues", {"name": names.box, "items": [{"mass_g": 200.0, "count": 2}]}),
        "no such source": ("DELETE", "/sources/" + quote(names.box, safe=""), None),
        "no readings": ("POST", f"/sessions/{key}/runs", {"kind": "initial", "take": take(names.source)}),
    }
    out = {}
    for name, (method, path, body) in asked.items():
        answer = shop.client.request(method, f"/api/v1{path}", json=body)
        out[f"refused {name}"] = "\n".join(texts_in(answer.json()))
    return out


def texts_in(document: object) -> Iterator[str]:
    """Every text of a JSON document."""
    if isinstance(document, str):
        yield document
    elif isinstance(document, dict | list):
        for part in document.values() if isinstance(document, dict) else document:
            yield from texts_in(part)


def take(source: str) -> dict[str, str]:
    return {"source": source, "from": "2026-01-01T00:00:00Z", "to": "2026-01-01T00:01:00Z"}


def run_with(masses: list[dict[str, Any]], names: Names, *sensors: str) -> dict[str, Any]:
    readings = [{"sensor": name, "amplitude": 1.0, "phase_deg": 1.0} for name in sensors or (names.sensor_p,)]
    return {"kind": "trial" if masses else "initial", "masses": masses, "readings": readings}


def shown(shop: Workshop, moment: str, paths: list[str]) -> dict[str, str]:
    """Pages in every reader's language and units."""
    out = {}
    for reader in READERS:
        headers = {"accept": "text/html", "cookie": f"{COOKIE}={reader.cookie()}"}
        for path in paths:
            answer = shop.client.get(path, headers=headers)
            assert answer.status_code == 200, (path, answer.text[:300])
            out[f"{moment} {path} {reader}"] = html.unescape(answer.text)
    return out


CHANGING = re.compile(r'(?:name="[a-z_]+" value="|nonce=")[\w.-]{16,}"|\b[0-9a-f]{16,}\b')
"""Keys and stamps of forms."""


def with_names(text: str, plain: Names, odd: Names) -> str:
    """A text with the plain names replaced, shortened ones too, as JSON writes them where it stands in JSON."""
    for field in fields(Names):
        before, after = getattr(plain, field.name), getattr(odd, field.name)
        text = text.replace(before, after)
    return text


@pytest.fixture(scope="module")
def plain(engine: Engine, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The session of plain names."""
    with fresh(engine, tmp_path_factory.mktemp("plain") / "db") as shop:
        return walked(shop, PLAIN)


@pytest.mark.arithmetic
@pytest.mark.parametrize("kind", ODD)
def test_names_are_the_same_on_every_page_certificate_and_refusal(
    engine: Engine, tmp_path: Path, plain: dict[str, str], kind: str
) -> None:
    odd = ODD[kind]
    assert [len(getattr(odd, f.name)) for f in fields(Names)] == [len(getattr(PLAIN, f.name)) for f in fields(Names)]
    with fresh(engine, tmp_path / "db") as shop:
        seen = walked(shop, odd)
    assert seen.keys() == plain.keys()
    for place, text in seen.items():
        wanted = CHANGING.sub("#", with_names(plain[place], PLAIN, odd)).splitlines()
        for line, (want, have) in enumerate(zip(wanted, CHANGING.sub("#", text).splitlines(), strict=True)):
            assert have == want, f"{place}, line {line}"
