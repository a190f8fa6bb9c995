"""Descriptions of fields in the API document: the text under each field of a document, read from its source.

pydantic reads them too, while it builds a validator; for that it parses the whole module once more for every class in
it. Here a module is parsed once, and only where a JSON schema is asked for.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from typing import Any

from pydantic import GetJsonSchemaHandler
from pydantic_core import CoreSchema


def describe(cls: type[Any], schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
    """The JSON schema of a document with the descriptions of its own fields and of those it inherits."""
    made = handler(schema)
    properties: dict[str, Any] = handler.resolve_ref_schema(made).get("properties", {})
    aliases = _aliases(schema)
    for one in cls.__mro__:
        for name, text in _texts_in(one.__module__).get(one.__qualname__, {}).items():
            shown = properties.get(aliases.get(name, name))
            if shown is not None:
                shown.setdefault("description", text)
    return made


def _aliases(schema: Any) -> Mapping[str, str]:
    """Names of the fields in JSON, by their names in Python."""
    fields = schema.get("schema", {}).get("fields", ()) if schema.get("type") == "dataclass" else ()
    return {one["name"]: str(one.get("validation_alias", one["name"])) for one in fields}


@cache
def _texts_in(module: str) -> Mapping[str, Mapping[str, str]]:
    """Texts under the fields of a module's classes: {class: {field: text}}; none where there is no source."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (OSError, TypeError):
        return {}
    return {node.name: _texts_of(node) for node in tree.body if isinstance(node, ast.ClassDef)}


def _texts_of(node: ast.ClassDef) -> Mapping[str, str]:
    return {
        field.target.id: inspect.cleandoc(text.value.value)
        for field, text in pairwise(node.body)
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant) and isinstance(text.value.value, str)
    }
