"""Every stored thing that the history tells of is compared with it; no alteration ends the comparison."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest
from sqlalchemy.orm import Session

from db import migrate
from db.verification import Walk
from drivers.reading import Reading
from service.cli.commands.verify import verify_history
from service.usecases.access import tokens
from service.usecases.readings import ingest
from service.usecases.readings.retention import retain
from tests.support.http.workshop import Workshop

DAY = datetime(2025, 12, 1, 12, tzinfo=UTC)


def reading(number: int, amplitude: float = 1.0) -> Reading:
    moment = DAY + timedelta(seconds=number)
    return Reading(source="bridge", sequence=number, taken_at=moment, sensor="P", amplitude=amplitude)


def fill(shop: Workshop) -> None:
    """An open session that is fitted, a closed one, readings in batches, some of them twice, a token, an answer."""
    machine, box = shop.machine(), shop.box()
    shop.ask("PUT", "/sources/bridge", {"machine_id": machine})
    for closed in (False, True):
        session = shop.session(machine, box, technician="A")
        shop.fit(shop.planned(session))
        if closed:
            shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    shop.post(
        f"/catalogues/{box}/stock", {"kind": "received", "pieces": [{"mass_g": 10.0, "pieces": 3}], "note": "new"}
    )
    tokens.create(shop.work, "tablet", ["read"])
    for numbers in (range(5), range(5, 10), range(8, 12)):
        ingest.ingest(shop.work, [reading(number) for number in numbers])
    masses = [{"plane": "1", "mass_g": 5.0, "angle_deg": 0.0}]
    shop.post("/balancer-answers", {"source": "bridge", "sequence": 1, "taken_at": DAY.isoformat(), "masses": masses})


@pytest.fixture(scope="module")
def full(shared_shop: Workshop) -> Workshop:
    """A workshop that tests alter in transactions which they undo."""
    fill(shared_shop)
    assert codes(shared_shop) == []
    return shared_shop


def codes(shop: Workshop, *statements: str) -> list[str]:
    """What a walk finds after these statements, which are undone."""
    with shop.work.database.engine.connect() as connection, Session(connection) as session:
        if shop.work.database.embedded:
            connection.exec_driver_sql("PRAGMA defer_foreign_keys = ON")
        for statement in statements:
            connection.exec_driver_sql(statement.replace("%", "%%"))
        found = sorted(finding.code for finding in Walk(session).findings())
        session.rollback()
    return found


OPEN = "(SELECT id FROM session WHERE state <> 'closed')"
CLOSED = "(SELECT id FROM session WHERE state = 'closed')"
ALTERED = {
    "radius of a machine": ("UPDATE machine SET spec = replace(spec, '330.0', '130.0')", "row_altered"),
    "masses of a box": ("UPDATE catalogue SET items = replace(items, '100.0', '999.0')", "row_altered"),
    "an open session": (f"UPDATE session SET note = 'x' WHERE id IN {OPEN}", "row_altered"),
    "a run of it": (
        f"UPDATE run SET run = replace(run, 'initial', 'trial') WHERE number = 1 AND session_id IN {OPEN}",
        "row_altered",
    ),
    "its plan": (
        f"UPDATE plan SET plan = replace(plan, 'optimal', 'better') WHERE session_id IN {OPEN}",
        "row_altered",
    ),
    "its correction": (
        f"UPDATE correction SET correction = replace(correction, 'fit', 'fat') WHERE session_id IN {OPEN}",
        "row_altered",
    ),
    "run removed": (f"DELETE FROM run WHERE number = 1 AND session_id IN {OPEN}", "row_missing"),
    "a closed run": (
        f"UPDATE run SET run = replace(run, 'initial', 'trial') WHERE number = 1 AND session_id IN {CLOSED}",
        "session_altered",
    ),
    "a token's scopes": ("""UPDATE token SET scopes = '["admin"]'""", "row_altered"),
    "a token's secret": ("UPDATE token SET digest = 'other'", "row_altered"),
    "a source": (
        "UPDATE source SET bound_at = '2020-01-01 00:00:00.000000' WHERE name = 'bridge'",
        "row_altered",
    ),
    "a balancer's answer": ("UPDATE balancer_answer SET masses = replace(masses, '5.0', '6.0')", "row_altered"),
    "note of a movement": (f"UPDATE stock_entry SET note = 'x' WHERE session_id IN {CLOSED}", "row_altered"),
    "movement of an open session": (f"UPDATE stock_entry SET note = 'x' WHERE session_id IN {OPEN}", "row_altered"),
    "one reading": ("UPDATE reading SET amplitude = 2.0 WHERE sequence = 3", "readings_altered"),
    "a reading sent twice": ("UPDATE reading SET amplitude = 2.0 WHERE sequence = 9", "readings_altered"),
    "readings removed": ("DELETE FROM reading WHERE sequence IN (2, 3)", "readings_missing"),
    "unchained line": (
        "INSERT INTO audit (at, actor, action, kind, key, changes) "
        "VALUES ('2026-01-01 00:00:00', 'x', 'changed', 'machine', 'm', '{}')",
        "entry_forged",
    ),
    "line that is no JSON": ("UPDATE audit SET changes = '{\"a' WHERE number = 3", "entry_altered"),
    "line with a NaN": ("UPDATE audit SET changes = '{\"a\":NaN}' WHERE number = 3", "entry_altered"),
    "line that is a list": ("UPDATE audit SET changes = '[]' WHERE number = 3", "entry_altered"),
    "closed run, no JSON": (f"UPDATE run SET run = '{{\"a' WHERE session_id IN {CLOSED}", "session_altered"),
    "closed run, NaN": (f"UPDATE run SET run = '{{\"a\":NaN}}' WHERE session_id IN {CLOSED}", "session_altered"),
    "closed run, 1e400": (f"UPDATE run SET run = '{{\"a\":1e400}}' WHERE session_id IN {CLOSED}", "session_altered"),
    "closed run, lone half": (
        f'UPDATE run SET run = \'{{"a":"\\ud800"}}\' WHERE session_id IN {CLOSED}',
        "session_altered",
    ),
    "ledger and balance alike": (
        "UPDATE stock_entry SET pieces = pieces + 100 WHERE id = (SELECT min(id) FROM stock_entry);"
        "UPDATE stock_balance SET on_hand = on_hand + 100 WHERE (catalogue_id, item) = "
        "(SELECT catalogue_id, item FROM stock_entry WHERE id = (SELECT min(id) FROM stock_entry))",
        "row_altered",
    ),
}


@pytest.mark.parametrize("case", ALTERED)
def test_an_alteration_behind_the_service_is_found(full: Workshop, case: str) -> None:
    statements, code = ALTERED[case]
    assert code in codes(full, *statements.split(";"))


BROKEN = {
    "time of a line": "UPDATE audit SET at = 'yesterday' WHERE number = 3",
    "number of a line": "UPDATE audit SET number = 'three' WHERE number = 3",
    "time of a closed session": f"UPDATE session SET created_at = 'x' WHERE id IN {CLOSED}",
    "time of a machine": "UPDATE machine SET created_at = 'x'",
    "time of a reading": "UPDATE reading SET taken_at = 'x' WHERE sequence = 3",
    "box row removed": "DELETE FROM catalogue",
    "amplitude of a reading": "UPDATE reading SET amplitude = 'much' WHERE sequence = 3",
}


@pytest.mark.only("sqlite")
@pytest.mark.parametrize("case", BROKEN)
def test_what_an_engine_without_types_can_hold_ends_no_walk(full: Workshop, case: str) -> None:
    assert codes(full, BROKEN[case])


def test_a_token_that_was_inserted_is_found(full: Workshop) -> None:
    columns = "'x', 'x', '[\"admin\"]', 'x', created_at"
    forged = f"INSERT INTO token (id, name, scopes, digest, created_at) SELECT {columns} FROM token"
    assert codes(full, forged) == ["row_inserted"]


def test_a_box_that_is_gone_is_named_by_the_command(shop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    box = shop.box(count=3, masses=(10.0,))
    with shop.work.database.engine.begin() as connection:
        connection.exec_driver_sql("UPDATE stock_balance SET on_hand = 1")
        connection.exec_driver_sql("UPDATE catalogue SET items = '[]'")
    assert verify_history(shop.work.database.url.render_as_string(hide_password=False), None) == 1
    told = capsys.readouterr().out
    assert f"row_altered: catalogue {box}" in told
    assert "has 1 of item 0" in told


def test_rolled_up_readings_are_not_missing_and_stay_known(shop: Workshop) -> None:
    shop.ask("PUT", "/sources/bridge", {"machine_id": shop.machine()})
    ingest.ingest(shop.work, [reading(number) for number in range(12)])
    retain(shop.work, 1)
    assert shop.count("reading") == 0
    rows = shop.count("reading_minute")
    assert codes(shop) == []
    receipt = ingest.ingest(shop.work, [reading(number) for number in range(2, 13)])
    assert (receipt.accepted, receipt.duplicates) == (1, 10)
    assert ingest.ingest(shop.work, [reading(3, amplitude=7.0)]).accepted == 0
    retain(shop.work, 1)
    assert shop.count("reading_minute") == rows + 1, "the late reading alone"
    assert shop.count("reading_range") == 1
    assert codes(shop) == []


def test_an_upgrade_attests_what_is_stored_and_alterations_after_it_are_found(shop: Workshop) -> None:
    fill(shop)
    migrate.downgrade(shop.work.database, "0011")
    migrate.upgrade(shop.work.database)
    assert codes(shop) == []
    assert codes(shop, ALTERED["radius of a machine"][0]) == ["row_altered"]


def test_history_shows_digests_apart_from_the_changes(shop: Workshop) -> None:
    shop.machine()
    line = shop.get("/history?kind=machine&limit=1")[0]
    assert list(line["rows"]) == [f"machine {line['key']}"]
    assert "#rows" not in line["changes"]
