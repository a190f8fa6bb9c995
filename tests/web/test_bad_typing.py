"""Whatever is typed into whatever form: an error in the reader's language beside the field, what was typed kept."""

from __future__ import annotations

import html
import re
from dataclasses import dataclass, field
from typing import Any

import pytest

from tests.api.workshop import Workshop
from tests.web.test_german_pages import GERMAN, english
from tests.web.test_undoing import LOCKED, send

EMOJI, PASTED, TURNED, LONG = "🙂", "3,1 mm/s\t<b>Lager</b>", "400", "x" * 3000
NUMBERS = (EMOJI, PASTED, "1.250", "1e5", "nan")
MACHINE = {
    "name": "Häcksler",
    "service_speed_rpm": "460",
    "rotor_mass_kg": "120,5",
    "planes": "1",
    "sensors": "1",
    "rotation": "cw",
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
RUN = {"readings[0].amplitude": "3,11", "readings[0].phase_deg": "40"}
BALANCER = {"source": "balancer", "masses[0].mass_g": "100", "masses[0].angle_deg": "40"} | {
    "masses[1].mass_g": "100",
    "masses[1].angle_deg": "40",
}
FORMS: dict[str, dict[str, str]] = {
    "/machines/new": MACHINE,
    "/boxes/new": BOX,
    "/boxes/{box}": {"counted[0]": "3"},
    "/sessions/new": {"machine_id": "{machine}"},
    "/sessions/{empty}/runs": RUN,
    "/sessions/{begun}/corrections": BALANCER,
    "/sessions/{trying}/stops/1/trial": {"masses.mass_g": "50", "masses.angle_deg": "20"},
    "/sessions/{fitting}/stops/1/plan": {
        "differs": "yes",
        "actual[0].position_deg": "20",
        "actual[0].mass_g": "10",
        "actual[1].position_deg": "20",
        "actual[1].mass_g": "10",
    },
}
BAD = [
    *(("/machines/new", "name", text) for text in ("", "  ", LONG, "a\x00b")),
    *(("/machines/new", "service_speed_rpm", text) for text in ("", "0", "-3", *NUMBERS)),
    *(("/machines/new", "rotor_mass_kg", text) for text in NUMBERS),
    *(("/machines/new", "planes[0].first_deg", text) for text in (TURNED, *NUMBERS)),
    *(("/machines/new", "planes[0].positions_deg", text) for text in (EMOJI, "0; 20; zwanzig", "0 400")),
    *(("/machines/new", "planes[0].holes", text) for text in ("", "2,5", EMOJI)),
    *(("/machines/new", name, text) for name in ("rotation", "angle_sense", "phase_sense") for text in (EMOJI,)),
    *(("/boxes/new", "name", text) for text in ("", LONG)),
    *(("/boxes/new", "items[0].mass_g", text) for text in ("", "0", *NUMBERS)),
    *(("/boxes/new", "items[0].count", text) for text in ("2,5", "0", EMOJI)),
    *(("/boxes/{box}", name, text) for name in ("received[0]", "counted[0]") for text in ("2,5", "-1", *NUMBERS)),
    *(("/sessions/new", "technician", text) for text in (LONG, "a\x00b")),
    *(("/sessions/{empty}/runs", "readings[0].amplitude", text) for text in ("", "-1", *NUMBERS)),
    *(("/sessions/{empty}/runs", "readings[0].phase_deg", text) for text in (TURNED, *NUMBERS)),
    *(("/sessions/{empty}/runs", "speed_rpm", text) for text in ("9000", *NUMBERS)),
    *(("/sessions/{begun}/corrections", "masses[0].mass_g", text) for text in ("", "-1", *NUMBERS)),
    *(("/sessions/{begun}/corrections", "masses[1].angle_deg", text) for text in ("", TURNED, *NUMBERS)),
    *(("/sessions/{trying}/stops/1/trial", "masses.mass_g", text) for text in ("", "0", *NUMBERS)),
    *(("/sessions/{trying}/stops/1/trial", "masses.angle_deg", text) for text in ("", TURNED, EMOJI)),
    *(("/sessions/{fitting}/stops/1/plan", "actual[0].weighed_g", text) for text in ("0", *NUMBERS)),
    *(("/sessions/{fitting}/stops/1/plan", "actual[0].position_deg", text) for text in ("", TURNED, EMOJI)),
]
COMMAS = [
    *(("/machines/new", name) for name in ("service_speed_rpm", "rotor_mass_kg", "planes[0].first_deg")),
    ("/boxes/new", "items[0].mass_g"),
    *(("/sessions/{empty}/runs", name) for name in ("readings[0].amplitude", "readings[0].phase_deg", "speed_rpm")),
]


@dataclass
class Desk:
    """A workshop with a session at each place where something is typed."""

    shop: Workshop
    names: dict[str, str] = field(default_factory=dict)

    def sent(self, form: str, **typed: str) -> Any:
        """The answer to a form, with these fields typed."""
        path = form.format(**self.names)
        fields = {name: text.format(**self.names) for name, text in FORMS[form].items()} | typed
        if "/sessions/{" in form:
            page = self.shop.client.get("/".join(path.split("/")[:3]), headers=GERMAN).text
            fields["stamp"] = re.search(r'name="stamp" value="(\w+)"', page).group(1)  # type: ignore[union-attr]
        return self.shop.client.post(path, data=fields, headers=GERMAN, follow_redirects=False)


@pytest.fixture(scope="module")
def desk(shared_shop: Workshop) -> Desk:
    shop, box = shared_shop, shared_shop.box()
    made = Desk(shop, {"machine": shop.machine(), "box": box})
    made.names |= {name: shop.session(made.names["machine"], box) for name in ("empty", "begun", "trying", "fitting")}
    for name in ("begun", "trying"):
        shop.run(made.names[name], "initial")
    send(shop, made.names["trying"], "stops", purpose="trial", plane="1")
    send(shop, made.names["trying"], "stops/1/lock", **LOCKED)
    plan = shop.planned(made.names["fitting"])
    send(shop, made.names["fitting"], "stops", purpose="plan", plan_id=plan["id"])
    send(shop, made.names["fitting"], "stops/1/lock", **LOCKED)
    return made


@pytest.mark.parametrize(("form", "name", "typed"), BAD, ids=lambda value: value[:12].strip() or "empty")
def test_what_is_wrong_is_told_beside_its_field_and_kept(desk: Desk, form: str, name: str, typed: str) -> None:
    before = desk.shop.rows()
    answer = desk.sent(form, **{name: typed})
    assert answer.status_code == 422
    assert desk.shop.rows() == before
    assert english(answer.text) == []
    where = answer.text.index(f'name="{name}"')
    beside = re.search(r'class="fault"[^>]*>\s*\S', answer.text[where:])
    assert beside is not None, "nothing is said beside the field"
    following = re.search(r'<(?:input|select)[^>]* name="(?!' + re.escape(name) + ")", answer.text[where:])
    assert following is None or beside.start() < following.start(), "what is said stands beside another field"
    tag = answer.text[answer.text.rindex("<", 0, where) : answer.text.index(">", where)]
    if tag.startswith("<input") and 'type="radio"' not in tag:
        assert f'value="{html.escape(typed)}"' in tag.replace("&#34;", "&quot;").replace("&#39;", "&#x27;")


@pytest.mark.parametrize(("form", "name"), COMMAS)
def test_a_decimal_comma_is_taken_where_the_language_has_one(desk: Desk, form: str, name: str) -> None:
    """Another field is wrong, so that nothing is stored: this one is not."""
    other = next(key for key in FORMS[form] if key != name and "name" not in key and "rows" not in key)
    answer = desk.sent(form, **{name: "12,5", other: EMOJI})
    assert answer.status_code == 422
    tag = re.search(rf'<input[^>]*name="{re.escape(name)}"[^>]*>', answer.text)
    assert tag is not None
    assert "aria-invalid" not in tag.group()
    assert 'value="12,5"' in tag.group()


def test_choices_that_are_none_change_nothing_and_break_nothing(desk: Desk) -> None:
    for sent in ({"language": EMOJI}, {"mass": PASTED, "theme": ""}, {"detection": LONG}):
        answer = desk.shop.client.post("/preferences", data=sent, headers=GERMAN, follow_redirects=False)
        assert answer.status_code == 303
    desk.shop.client.cookies.delete("drumtrue_preferences")
