"""Whatever is typed into whatever form: an error in the reader's language beside the field, what was typed kept."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest

from service.web.session.guide import look
from tests.support.http.workshop import Workshop
from tests.support.pages.posted import POSTED
from tests.web.session.test_undoing import LOCKED, RELEASED, send
from tests.web.test_german_pages import GERMAN, english

EMOJI, PASTED, TURNED, LONG = "🙂", "3,1 mm/s\t<b>Lager</b>", "400", "x" * 3000
NUMBERS = (EMOJI, PASTED, "1.250", "1e5", "nan")
WORDS = (LONG, "a\x00b", "Band\tBolzen")
MACHINE = {
    "name": "Häcksler",
    "service_speed_rpm": "460",
    "rotor_mass_kg": "120,5",
    "planes": "1",
    "sensors": "1",
    "rotation": "cw",
    "seen_from": "Riemen",
    "angle_sense": "against_rotation",
    "phase_sense": "lag",
    "planes[0].name": "1",
    "planes[0].radius_mm": "330",
    "planes[0].holes": "18",
    "planes[0].first_deg": "0",
    "planes[0].max_masses": "3",
    "planes[0].masses_per_position": "1",
    "sensors[0].name": "A",
    "sensors[0].unit": "mm/s",
    "sensors[0].detection": "rms",
}
BOX = {"name": "Kasten", "rows": "6", "items[0].mass_g": "10", "items[0].count": "5"}
AS_FOUND = {"machine_id": "{machine}", "known": "yes", "on_rotor[0].place": "0 20", "on_rotor[0].mass_g": "10"}
RUN = {"readings[0].amplitude": "3,11", "readings[0].phase_deg": "40"}
BALANCER = {"source": "balancer", "masses[0].mass_g": "100", "masses[0].angle_deg": "40"} | {
    "masses[1].mass_g": "100",
    "masses[1].angle_deg": "40",
}
FORMS: dict[str, dict[str, str]] = {
    "/machines/new": MACHINE,
    "/machines/{machine}/edit": MACHINE,
    "/boxes/new": BOX,
    "/boxes/{box}": {"counted[0]": "3"},
    "/sources": {"name": "drum", "machine_id": "{machine}"},
    "/login": {"token": ""},
    "/sessions/new": {
        "machine_id": "{machine}",
        "known": "yes",
        "on_rotor[0].place": "0 20",
        "on_rotor[0].mass_g": "10",
    },
    "/sessions/{empty}/runs": RUN,
    "/sessions/{begun}/corrections": BALANCER,
    "/sessions/{boxless}/box": {"catalogue_id": "{box}"},
    "/sessions/{corrected}/plans": {"objective": "residual_vibration", "mode": "best", "max_masses_per_plane": "1"},
    "/sessions/{stopped}/stops/1/lock": LOCKED,
    "/sessions/{trying}/stops/1/trial": {"masses.mass_g": "50", "masses.angle_deg": "20"},
    "/sessions/{bolted}/stops/1/release": RELEASED,
    "/sessions/{fitting}/stops/1/plan": {
        "differs": "yes",
        "actual[0].position_deg": "20",
        "actual[0].mass_g": "10",
        "actual[1].position_deg": "20",
        "actual[1].mass_g": "10",
    },
}
NOTHING_TYPED = {
    "/logout": {},
    "/preferences": {"language": EMOJI, "mass": PASTED, "theme": "", "detection": LONG},
    "/sessions/{empty}/runs/take": {"anyway": EMOJI},
    "/sessions/{begun}/runs/none/exclude": {"excluded": EMOJI, "reason": LONG},
    "/sessions/{corrected}/plans/none/again": {"blocked_plane": EMOJI, "blocked_deg": TURNED, "missing_g": PASTED},
    "/sessions/{begun}/stops": {"purpose": EMOJI, "plane": LONG, "alternative": "2,5"},
    "/sessions/{stopped}/stops/1/bare": {"differs": EMOJI},
    "/sessions/{bolted}/stops/7/correct": {"number": EMOJI},
    "/sessions/{bolted}/runs/x/repeat": {"number": EMOJI},
    "/sessions/{fitting}/stops/7/cancel": {"number": EMOJI},
    "/sessions/{empty}/teach": {"session_id": EMOJI},
    "/sessions/{empty}/close": {"stamp": EMOJI},
}
"""Forms of buttons alone, with what no page sends."""
TRIED_BESIDE = ("/arrangements/", "/designs/", "/machines/x/parts/")
"""Forms whose wrong fields tests/web/parts and tests/web/test_design_pages.py try."""
UNTRIED = {"keep", "actual[x].left_out", "done[x]"}
"""Ticks that may be set or not: neither is wrong."""
COUNTS = {"rows", "planes", "sensors", "planes[0].name"}
"""Figures that say how long a form is, and a name that looks like one."""
KEPT_SECRET = {"token"}
"""What is typed there is never shown again."""


def _of_a_machine() -> Iterator[tuple[str, str]]:
    """Fields of the machine's form, each with what is wrong in it."""
    needed = ("service_speed_rpm", "planes[0].radius_mm")
    free = (
        "rotor_mass_kg",
        "balance_grade_mm_s",
        "vibration_limit_mm_s",
        "planes[0].axial_mm",
        "planes[0].max_force_n",
        "sensors[0].axial_mm",
        "sensors[0].limit",
    )
    yield from ((name, text) for name in needed for text in ("", "0", "-3", *NUMBERS))
    yield from ((name, text) for name in free for text in NUMBERS)
    yield from (("planes[0].first_deg", text) for text in (TURNED, *NUMBERS))
    yield from (("planes[0].positions_deg", text) for text in (EMOJI, "0; 20; zwanzig", "0 400"))
    yield from (("planes[0].hole_labels", text) for text in ("1 2 3", LONG, "a\x00b"))
    for name in ("planes[0].holes", "planes[0].max_masses", "planes[0].masses_per_position"):
        yield from ((name, text) for text in ("", "2,5", EMOJI))
    for name in ("rotation", "angle_sense", "phase_sense", "sensors[0].unit", "sensors[0].detection"):
        yield name, EMOJI
    yield from ((name, text) for name in ("name", "planes[0].name", "sensors[0].name") for text in ("", "  ", *WORDS))
    yield from ((name, text) for name in ("type", "seen_from", "sensors[0].serial") for text in WORDS)


BAD = [
    *(("/machines/new", name, text) for name, text in _of_a_machine()),
    *(("/machines/{machine}/edit", name, text) for name, text in _of_a_machine() if text in ("", EMOJI, TURNED, LONG)),
    *(("/boxes/new", "name", text) for text in ("", LONG)),
    *(("/boxes/new", "items[0].mass_g", text) for text in ("", "0", *NUMBERS)),
    *(("/boxes/new", "items[0].count", text) for text in ("2,5", "0", EMOJI)),
    *(("/boxes/new", "items[0].fastener_g", text) for text in ("-1", *NUMBERS)),
    *(("/boxes/{box}", name, text) for name in ("received[0]", "counted[0]") for text in ("2,5", "-1", *NUMBERS)),
    *(("/sources", "name", text) for text in ("", "  ", *WORDS)),
    *(("/sources", "machine_id", text) for text in ("", EMOJI, LONG)),
    *(("/login", "token", text) for text in ("", EMOJI, PASTED, *WORDS)),
    *(("/sessions/new", "catalogue_id", text) for text in (EMOJI, LONG)),
    *(("/sessions/new", "machine_id", text) for text in ("", EMOJI, LONG)),
    *(("/sessions/new", name, text) for name in ("technician", "note") for text in WORDS),
    *(("/sessions/new", "on_rotor[0].place", text) for text in ("", EMOJI, "9 20")),
    *(("/sessions/new", "on_rotor[0].mass_g", text) for text in ("", "0", *NUMBERS)),
    *(("/sessions/new", "on_rotor[0].may", text) for text in (EMOJI,)),
    *(("/sessions/new", "run_out[0].amplitude", text) for text in ("-1", *NUMBERS)),
    *(("/sessions/new", "run_out[1].phase_deg", text) for text in (TURNED, *NUMBERS)),
    *(("/sessions/{empty}/runs", "readings[0].amplitude", text) for text in ("", "-1", *NUMBERS)),
    *(("/sessions/{empty}/runs", "readings[0].phase_deg", text) for text in (TURNED, *NUMBERS)),
    *(("/sessions/{empty}/runs", "speed_rpm", text) for text in ("9000", *NUMBERS)),
    *(("/sessions/{begun}/corrections", "masses[0].mass_g", text) for text in ("", "-1", *NUMBERS)),
    *(("/sessions/{begun}/corrections", "masses[1].angle_deg", text) for text in ("", TURNED, *NUMBERS)),
    *(("/sessions/{boxless}/box", "catalogue_id", text) for text in ("", EMOJI, LONG)),
    *(("/sessions/{corrected}/plans", name, text) for name in ("mode", "objective") for text in (EMOJI, LONG)),
    *(("/sessions/{corrected}/plans", "max_masses_per_plane", text) for text in (TURNED, "2,5", EMOJI)),
    *(("/sessions/{stopped}/stops/1/lock", name, "") for name in LOCKED),
    *(("/sessions/{bolted}/stops/1/release", name, "") for name in RELEASED),
    *(("/sessions/{trying}/stops/1/trial", "masses.mass_g", text) for text in ("", "0", *NUMBERS)),
    *(("/sessions/{trying}/stops/1/trial", "masses.angle_deg", text) for text in ("", TURNED, EMOJI)),
    *(("/sessions/{fitting}/stops/1/plan", "actual[0].weighed_g", text) for text in ("0", *NUMBERS)),
    *(("/sessions/{fitting}/stops/1/plan", "actual[0].position_deg", text) for text in ("", TURNED, EMOJI)),
    *(("/sessions/{fitting}/stops/1/plan", "actual[0].mass_g", text) for text in ("", EMOJI)),
]
COMMAS = [
    *(("/machines/new", name) for name in ("service_speed_rpm", "rotor_mass_kg", "planes[0].first_deg")),
    *(("/machines/{machine}/edit", name) for name in ("planes[0].radius_mm", "sensors[0].axial_mm")),
    *(("/boxes/new", name) for name in ("items[0].mass_g", "items[0].fastener_g")),
    *(("/sessions/{empty}/runs", name) for name in ("readings[0].amplitude", "readings[0].phase_deg", "speed_rpm")),
    *(("/sessions/{begun}/corrections", name) for name in ("masses[0].mass_g", "masses[1].angle_deg")),
    ("/sessions/{trying}/stops/1/trial", "masses.mass_g"),
    ("/sessions/{fitting}/stops/1/plan", "actual[0].weighed_g"),
]


def route(form: str) -> str:
    """The route of a form's address, each parameter an x."""
    return re.sub(r"{\w+}|\b(\d+|none)\b", "x", form)


@dataclass
class Desk:
    """A workshop with a session at each place where something is typed."""

    shop: Workshop
    names: dict[str, str] = field(default_factory=dict)
    stored: dict[str, list[Any]] = field(default_factory=dict)

    def has_changed(self) -> bool:
        """Whether anything was stored since this was asked last."""
        before, self.stored = self.stored, self.shop.rows()
        return before != self.stored

    def sent(self, form: str, **typed: str) -> Any:
        """The answer to a form, with these fields typed."""
        path = form.format(**self.names)
        usual = FORMS.get(form, {})
        fields = {name: text.format(**self.names) for name, text in usual.items()} | typed
        if "/sessions/{" in form:
            fields["stamp"] = look(self.shop.work, path.split("/")[2]).stamp
        return self.shop.client.post(path, data=fields, headers=GERMAN, follow_redirects=False)

    def page(self, form: str) -> str:
        """The page that has the form on it."""
        path = form.format(**self.names)
        shown = "/".join(path.split("/")[:3]) if "/sessions/{" in form else path
        return str(self.shop.client.get(shown, headers=GERMAN).text)


@pytest.fixture(scope="module")
def desk(shared_shop: Workshop) -> Desk:
    shop, box = shared_shop, shared_shop.box()
    made = Desk(shop, {"machine": shop.machine(), "box": box})
    places = ("empty", "begun", "stopped", "trying", "bolted", "corrected", "fitting")
    names = {name: shop.session(made.names["machine"], box) for name in places}
    names["boxless"] = str(shop.post("/sessions", {"machine_id": made.names["machine"]})["id"])
    made.names |= names
    for name in ("begun", "stopped", "trying", "bolted"):
        shop.run(names[name], "initial")
    for name in ("stopped", "trying", "bolted"):
        send(shop, names[name], "stops", purpose="trial", plane="1")
    for name in ("trying", "bolted"):
        send(shop, names[name], "stops/1/lock", **LOCKED)
    send(shop, names["bolted"], "stops/1/trial", **{"masses.mass_g": "50", "masses.angle_deg": "20", "sure.50": "yes"})
    for name in ("corrected", "boxless"):
        shop.learn(names[name])
        shop.correct(names[name])
    plan = shop.planned(names["fitting"])
    send(shop, names["fitting"], "stops", purpose="plan", plan_id=plan["id"])
    send(shop, names["fitting"], "stops/1/lock", **LOCKED)
    made.has_changed()
    return made


def test_every_form_of_the_pages_is_in_the_table() -> None:
    assert sorted(map(route, (*FORMS, *NOTHING_TYPED))) == [
        path for path in POSTED if not path.startswith(TRIED_BESIDE)
    ]
    assert {form for form, _, _ in BAD} == set(FORMS)


@pytest.mark.parametrize("form", FORMS)
def test_every_field_of_a_form_is_in_the_table(desk: Desk, form: str) -> None:
    page, path = desk.page(form), form.format(**desk.names)
    forms = [part for part in re.findall(r"(?s)<form[^>]*>.*?</form>", page) if f'action="{path}"' in part]
    assert forms, "the form is not on its page"
    typable = {
        re.sub(r"\[\d+\]", "[x]", name)
        for part in forms
        for tag, name in re.findall(r'<(input|select|textarea)[^>]* name="([^"]+)"', part)
        if not re.search(rf'<input[^>]*type="hidden"[^>]*name="{re.escape(name)}"', part)
    }
    tried = {re.sub(r"\[\d+\]", "[x]", name) for one, name, _ in BAD if one == form}
    assert typable - tried <= UNTRIED, "a field without a row"


@pytest.mark.parametrize(("form", "name", "typed"), BAD, ids=lambda value: value[:12].strip() or "empty")
def test_what_is_wrong_is_told_beside_its_field_and_kept(desk: Desk, form: str, name: str, typed: str) -> None:
    answer = desk.sent(form, **{name: typed})
    assert answer.status_code == (401 if name in KEPT_SECRET and typed else 422)
    assert not desk.has_changed()
    assert english(answer.text) == []
    where = answer.text.index(f'name="{name}"')
    beside = re.search(r'class="fault"[^>]*>\s*\S', answer.text[where:])
    assert beside is not None, "nothing is said beside the field"
    following = re.search(r'<(?:input|select)[^>]* name="(?!' + re.escape(name) + ")", answer.text[where:])
    assert following is None or beside.start() < following.start(), "what is said stands beside another field"
    tag = answer.text[answer.text.rindex("<", 0, where) : answer.text.index(">", where)]
    if name in KEPT_SECRET:
        assert html.escape(typed) not in answer.text or not typed
    elif tag.startswith("<input") and not re.search('type="(radio|checkbox)"', tag):
        assert f'value="{html.escape(typed)}"' in tag.replace("&#34;", "&quot;").replace("&#39;", "&#x27;")


@pytest.mark.parametrize(("form", "name"), COMMAS)
def test_a_decimal_comma_is_taken_where_the_language_has_one(desk: Desk, form: str, name: str) -> None:
    """Another field is wrong, so that nothing is stored: this one is not."""
    figures = (key for key, text in FORMS[form].items() if re.fullmatch(r"[\d,]+", text) and key not in COUNTS)
    other = next(key for key in figures if key != name)
    answer = desk.sent(form, **{name: "12,5", other: EMOJI})
    assert answer.status_code == 422
    tag = re.search(rf'<input[^>]*name="{re.escape(name)}"[^>]*>', answer.text)
    assert tag is not None
    assert "aria-invalid" not in tag.group()
    assert 'value="12,5"' in tag.group()


@pytest.mark.parametrize("form", NOTHING_TYPED)
def test_what_no_button_sends_changes_nothing_and_breaks_nothing(desk: Desk, form: str) -> None:
    answer = desk.sent(form, **NOTHING_TYPED[form])
    assert answer.status_code in (303, 404, 409, 422)
    assert not desk.has_changed() or form.endswith("/close")
    assert english(answer.text) == []
    desk.shop.client.cookies.delete("drumtrue_preferences")
