"""All queries, over the session of one unit of work."""

from __future__ import annotations

from db.queries.access import Access
from db.queries.audit import Past
from db.queries.readings import Readings
from db.queries.records import Records
from db.queries.stock import Stock


class Store(Records, Readings, Stock, Access, Past):
    """What is stored, seen from inside one unit of work."""
