"""Time for statements; the bounded connection is known by its attribute, so that SQLite loads no psycopg."""

from __future__ import annotations

from sqlalchemy import Connection


def be_patient(connection: Connection, patience_s: float) -> None:
    """Let statements of a unit of work over PostgreSQL take longer, s, up to its end."""
    driver = connection.connection.driver_connection
    if driver is not None and getattr(driver, "patience_s", None) is not None:
        driver.patience_s = patience_s  # the next unit of work sets it back, as it tries the connection
