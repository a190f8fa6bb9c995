"""A reading as it is sent: its time may be left out by a sender that has no clock."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from drivers.reading import NO_CLOCK, Reading


class _WithoutClock:
    """Makes `taken_at` of a reading optional on the wire; NO_CLOCK stands for one that is left out."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema: Any = handler.resolve_ref_schema(handler(source))
        for field in schema["schema"]["fields"]:
            if field["name"] == "taken_at":
                field["schema"] = core_schema.with_default_schema(field["schema"], default=NO_CLOCK)
        return schema  # type: ignore[no-any-return]

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        found = handler(schema)
        described = handler.resolve_ref_schema(found)
        described["required"] = [name for name in described["required"] if name != "taken_at"]
        described["properties"]["taken_at"].pop("default", None)
        return found


SentReading = Annotated[Reading, _WithoutClock()]
