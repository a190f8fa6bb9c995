"""What cannot be read is named, set apart, and takes nothing else with it; what needs no guess is mended."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import text

from db import migrate
from db.rows import RunRow
from service.cli.commands.repair import repair_database
from service.cli.commands.transfer import export_sessions, import_sessions
from service.cli.commands.verify import verify_history
from service.errors import InvalidInput
from service.model.run import Run
from service.usecases.repair import repair
from tests.support.http.workshop import Workshop

TINY = 1.3e-17
BROKEN: dict[str, Callable[[Any], Any]] = {
    "scatter": lambda run: {**run, "readings": [{**run["readings"][0], "scatter": TINY}, *run["readings"][1:]]},
    "unknown field": lambda run: {**run, "newer": True},
    "missing field": lambda run: {name: run[name] for name in run if name != "kind"},
    "no run at all": lambda _run: [],
}
TEXTS = {
    "no JSON": '{"id": "a',
    "NaN": '{"number": NaN}',
    "too great": '{"number": 1e400}',
    "lone": '{"id": "\\ud800"}',
}


def address(shop: Workshop) -> str:
    return shop.work.database.url.render_as_string(hide_password=False)


def write_run(shop: Workshop, run: str, document: str) -> None:
    """Put a text into the row of a run, as an older version or a damaged disk would."""
    with shop.work.database.engine.begin() as connection:
        connection.execute(text("UPDATE run SET run = :run WHERE id = :id"), {"run": document, "id": run})


def two_sessions(shop: Workshop) -> tuple[str, str, list[Any]]:
    """A session with a plan, another one beside it, and the runs of the first."""
    session, other = shop.session(), shop.session()
    shop.planned(session)
    shop.run(other, "initial")
    return session, other, shop.get(f"/sessions/{session}")["runs"]


def documents() -> list[str]:
    return [*BROKEN, *TEXTS]


def broken(case: str, run: Any) -> str:
    return TEXTS[case] if case in TEXTS else json.dumps(BROKEN[case](run))


@pytest.mark.parametrize("case", documents())
def test_an_unreadable_run_takes_nothing_else_with_it(shop: Workshop, case: str, tmp_path: Path) -> None:
    session, other, runs = two_sessions(shop)
    write_run(shop, runs[1]["id"], broken(case, runs[1]))
    seen = shop.get(f"/sessions/{session}")
    assert [run["number"] for run in seen["runs"]] == [1, 3]
    (apart,) = seen["unreadable"]
    assert (apart["kind"], apart["id"], apart["number"]) == ("run", runs[1]["id"], 2)
    assert apart["rule"]
    assert len(shop.get("/sessions")) == 2
    for page in ("/", "/sessions", f"/sessions/{session}", f"/sessions/{session}/runs", f"/sessions/{session}/report"):
        assert shop.client.get(page, headers={"accept": "text/html"}).status_code == 200, page
    said = shop.client.get(f"/sessions/{session}/runs", headers={"accept": "text/html"}).text
    assert "left out here: run 2" in said
    assert shop.get(f"/sessions/{session}/log")["unreadable"] == [apart]
    assert shop.get(f"/sessions/{session}/report.json")
    shop.refused(
        "PATCH", f"/sessions/{session}/runs/{runs[1]['id']}", {"excluded": True, "reason": "x"}, 409, "row_unreadable"
    )
    shop.ask("PATCH", f"/sessions/{session}/runs/{runs[2]['id']}", {"excluded": True, "reason": "mistyped"})
    assert shop.run(session, "initial")["number"] == 4
    assert export_sessions([], tmp_path / "all.jsonl", address(shop)) == 1
    lines = (tmp_path / "all.jsonl").read_text().splitlines()
    assert [json.loads(line)["session_id"] for line in lines] == [other]
    shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    assert verify_history(address(shop), None) == 0
    write_run(shop, runs[1]["id"], '{"id": "b')
    assert verify_history(address(shop), None) == 1


def test_an_export_names_what_it_leaves_out(shop: Workshop, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    session, other, runs = two_sessions(shop)
    write_run(shop, runs[1]["id"], broken("scatter", runs[1]))
    assert export_sessions([], tmp_path / "all.jsonl", address(shop)) == 1
    told = capsys.readouterr().err
    assert f"session {session}: run 2 cannot be read (run.readings[0].scatter)" in told
    assert other not in told
    import_sessions(tmp_path / "all.jsonl", address(shop))
    log = tmp_path / "log.json"
    log.write_text(json.dumps(shop.get(f"/sessions/{session}/log")))
    with pytest.raises(InvalidInput) as refused:
        import_sessions(log, address(shop))
    assert refused.value.code == "log_incomplete"


def test_a_scatter_below_its_rule_is_mended_with_a_line_of_history(
    shop: Workshop, capsys: pytest.CaptureFixture[str]
) -> None:
    session, _, runs = two_sessions(shop)
    write_run(shop, runs[1]["id"], broken("scatter", runs[1]))
    write_run(shop, runs[2]["id"], broken("unknown field", runs[2]))
    version = shop.get(f"/sessions/{session}")["version"]
    assert repair_database(address(shop), mend=False) == 1
    assert "2 unreadable documents, nothing was changed" in capsys.readouterr().out
    assert repair_database(address(shop), mend=True) == 1
    told = capsys.readouterr().out
    assert f"mended: run {runs[1]['id']}" in told
    assert f"cannot be read: run {runs[2]['id']}: run.newer" in told
    seen = shop.get(f"/sessions/{session}")
    assert seen["runs"][1] == runs[1]
    assert seen["version"] == version + 1
    line = shop.get(f"/sessions/{session}/history?limit=1")[0]
    assert (line["action"], line["kind"], line["key"]) == ("changed", "run", runs[1]["id"])
    before, after = line["changes"]["run.readings"]
    assert (before[0]["scatter"], after[0]["scatter"]) == (TINY, None)
    capsys.readouterr()
    assert verify_history(address(shop), None) == 1
    assert capsys.readouterr().out.splitlines()[0] == f"row_altered: run {runs[2]['id']} was altered behind the service"
    assert repair(shop.work).mended == ()


def test_a_closed_session_is_mended_only_where_it_cannot_be_read_and_sealed_anew(shop: Workshop) -> None:
    session, other, runs = two_sessions(shop)
    rounding = {**runs[0], "readings": [{**runs[0]["readings"][0], "scatter": 2e-15}]}
    write_run(shop, runs[0]["id"], json.dumps(rounding))
    write_run(shop, runs[1]["id"], broken("scatter", runs[1]))
    for one in (session, other):
        shop.ask("PATCH", f"/sessions/{one}", {"state": "closed"})
    assert repair(shop.work).mended == (("run", runs[1]["id"]),)
    assert verify_history(address(shop), None) == 0
    assert shop.get(f"/sessions/{session}")["runs"][0]["readings"][0]["scatter"] == 2e-15
    assert shop.get(f"/sessions/{session}/history?limit=1")[0]["action"] == "repaired"
    write_run(shop, runs[1]["id"], json.dumps(runs[0]))
    assert verify_history(address(shop), None) == 1


def test_the_migration_repairs_what_is_stored(shop: Workshop) -> None:
    session, _, runs = two_sessions(shop)
    write_run(shop, runs[1]["id"], broken("scatter", runs[1]))
    migrate.downgrade(shop.work.database, "0010")
    migrate.upgrade(shop.work.database)
    assert shop.get(f"/sessions/{session}")["runs"] == runs
    line = shop.get(f"/sessions/{session}/history?limit=1")[0]
    assert (line["actor"], line["kind"], line["key"]) == ("migration", "run", runs[1]["id"])
    assert verify_history(address(shop), None) == 0


def test_a_document_that_could_not_be_read_again_is_refused_when_it_is_written(shop: Workshop) -> None:
    """Whatever code computed it: the rules of reading are asked by the column itself."""
    session = shop.session()
    run = shop.run(session, "initial")
    before = shop.rows()

    def write(found: Run) -> None:
        with shop.work.write() as store:
            row = store.get(RunRow, found.id)
            assert row is not None
            row.run = found

    with shop.work.read() as store:
        row = store.get(RunRow, run["id"])
        assert row is not None
        good = row.run
    for wrong in (float("nan"), TINY, -1.0):
        reading = type(good.readings[0])(sensor="P", amplitude=1.0, phase_deg=None, scatter=wrong)
        with pytest.raises(InvalidInput) as refused:
            write(type(good)(**{**vars(good), "readings": (reading,)}))
        assert refused.value.code == "document_refused"
        assert refused.value.field == "readings[0].scatter"
    assert shop.rows() == before


@pytest.mark.parametrize("table", ["machine", "catalogue", "session"])
def test_other_rows_that_cannot_be_read_are_left_out_or_named(shop: Workshop, table: str, tmp_path: Path) -> None:
    session, other, _ = two_sessions(shop)
    column = {"machine": "spec", "catalogue": "items", "session": "on_rotor"}[table]
    key = {"session": session}.get(table) or shop.get(f"/sessions/{session}")[f"{table}_id"]
    with shop.work.database.engine.begin() as connection:
        connection.execute(text(f"UPDATE {table} SET {column} = '[1' WHERE id = :id"), {"id": key})
    assert len(shop.get("/sessions")) == 2
    assert len(shop.get("/machines")) == (1 if table == "machine" else 2)
    assert len(shop.get("/catalogues")) == (1 if table == "catalogue" else 2)
    for page in ("/", "/sessions", "/machines", "/boxes", f"/sessions/{other}"):
        assert shop.client.get(page, headers={"accept": "text/html"}).status_code == 200, page
    if table != "session":
        shop.get(f"/sessions/{session}")
        shop.refused("GET", f"/{table}s/{key}", None, 409, "row_unreadable")
    else:
        shop.refused("GET", f"/sessions/{key}", None, 409, "row_unreadable")
    assert export_sessions([], tmp_path / "all.jsonl", address(shop)) == (0 if table == "machine" else 1)
    (left,) = repair(shop.work).unreadable
    assert (left.kind, left.key) == (table, key)
