"""A disk that is full refuses what is to be stored, in words; once there is room all goes on."""

from __future__ import annotations

import logging

import pytest
from sqlalchemy.exc import OperationalError

from db.database import Database, lacks_room
from tests.support.http.workshop import Workshop, box_body


class Refused(Exception):
    """What an engine's driver raises, as far as it is looked at."""

    def __init__(self, **codes: object) -> None:
        super().__init__("refused")
        vars(self).update(codes)


def limit_pages(database: Database, pages: int) -> None:
    """Let the database's file grow to so many pages, or not beyond those it has."""
    with database.engine.connect() as connection:
        connection.exec_driver_sql(f"PRAGMA max_page_count={pages}")


@pytest.mark.only("sqlite")
def test_a_full_disk_is_told_and_no_longer_once_there_is_room(shop: Workshop, caplog: pytest.LogCaptureFixture) -> None:
    box, large = shop.box(), box_body("large", masses=[float(n) for n in range(1, 301)])
    limit_pages(shop.work.database, 1)
    problem = shop.refused("POST", "/catalogues", large, 503, "storage_full")
    assert "full" in problem["detail"]
    assert "make room" in problem["advice"]
    told = [line for line in caplog.records if line.levelno >= logging.WARNING]
    assert [(line.name, line.exc_info) for line in told] == [("drumtrue.storage", None)]
    assert shop.on_hand(box)
    limit_pages(shop.work.database, 1_000_000)
    assert shop.post("/catalogues", large)


@pytest.mark.parametrize(
    ("codes", "full"),
    [
        ({"sqlite_errorcode": 13}, True),
        ({"sqlite_errorcode": 778}, True),
        ({"sqlite_errorcode": 266}, False),
        ({"sqlite_errorcode": 5}, False),
        ({"sqlstate": "53100"}, True),
        ({"sqlstate": "57P01"}, False),
    ],
    ids=["SQLITE_FULL", "SQLITE_IOERR_WRITE", "SQLITE_IOERR_READ", "SQLITE_BUSY", "disk_full", "admin_shutdown"],
)
def test_the_engines_codes_tell_a_full_disk(codes: dict[str, object], full: bool) -> None:
    assert lacks_room(OperationalError("COMMIT", None, Refused(**codes))) == full
