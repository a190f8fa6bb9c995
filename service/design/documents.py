"""Design documents: TOML or JSON text in, plain tables out; presets of the published systems; patches."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping
from importlib import resources
from typing import Any

from service.design.findings import refusal
from service.design.reading import told
from service.messages import Message

VERSION = 1
MAX_BYTES = 1_000_000
"""Largest document, bytes; a linkage of fifty links has a hundredth of it."""
KEYS = ("name", "link", "joint", "wheel")
"""Fields by which the tables of a list are told apart when a patch is laid over them."""


def read_document(text: str) -> dict[str, Any]:
    """The tables of a document; JSON where it begins with a brace, TOML otherwise. Raises RefusedDesign."""
    size = len(text.encode(errors="replace"))
    if size > MAX_BYTES:
        raise refusal(Message("design_too_large", value=size, most=MAX_BYTES))
    is_json = text.lstrip()[:1] == "{"
    try:
        document = json.loads(text) if is_json else tomllib.loads(text)
    except (ValueError, RecursionError) as wrong:
        format_ = "JSON" if is_json else "TOML"
        raise refusal(Message("design_not_a_document", value=str(wrong), format=format_)) from None
    if not isinstance(document, dict):
        raise refusal(Message("design_not_a_document.table", value=told(document)))
    return document


def presets() -> tuple[str, ...]:
    """Names of the published systems that the product brings."""
    return tuple(sorted(file.name.removesuffix(".toml") for file in _files() if file.name.endswith(".toml")))


def preset_text(name: str) -> str:
    """The file of a published system, TOML. Raises RefusedDesign for an unknown name."""
    if name not in presets():
        raise refusal(Message("design_name_unknown", field="name", value=name, known=", ".join(presets())))
    return (resources.files("service.design") / "presets" / f"{name}.toml").read_text(encoding="utf-8")


def preset(name: str) -> dict[str, Any]:
    """The document of a published system. Raises RefusedDesign for an unknown name."""
    return read_document(preset_text(name))


def patched(document: Mapping[str, Any], patch: Mapping[str, Any]) -> dict[str, Any]:
    """A document with a patch laid over: tables are merged, lists of named tables by name, the rest is replaced."""
    merged = dict(document)
    for name, value in patch.items():
        old = merged.get(name)
        if isinstance(old, Mapping) and isinstance(value, Mapping):
            merged[name] = patched(old, value)
        elif _named(old) and _named(value):
            merged[name] = _by_name(old, value)
        else:
            merged[name] = value
    return merged


def _named(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(_key(one) is not None for one in value)


def _key(table: object) -> tuple[str, str] | None:
    if not isinstance(table, Mapping):
        return None
    return next(((key, table[key]) for key in KEYS if isinstance(table.get(key), str)), None)


def _by_name(old: Any, new: Any) -> list[dict[str, Any]]:
    patches = {_key(one): one for one in new}
    merged = [patched(one, patches.pop(_key(one), {})) for one in old]
    return merged + [dict(one) for one in patches.values()]


def _files() -> Iterator[Any]:
    return iter((resources.files("service.design") / "presets").iterdir())
