"""The reference of all codes with their texts and parameters; `python -m tests.messages.codes` writes it again."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

from service.messages.catalogue import SOURCE, Entry, Text, entries
from tests.messages.sources import ROOT, all_made

PATH = ROOT / "docs" / "reference" / "codes.md"
HEAD = """\
# Codes of errors and findings

Every error of the API (`code`), every finding (`diagnostics`, `warnings`) and every reason has a stable code and a
text in the catalogue `service/messages/texts`. `key` in an answer is the code, or `code.variant` where a code has
several texts; `parameters` holds the values named in braces. Masses are in g, lengths in mm, angles in degrees and
speeds in r/min, whatever unit a page shows. A key is never used again for something else; its wording may change.

This page is written by `python -m tests.messages.codes`.
"""


def written() -> str:
    """The page as the code and the catalogue of today have it."""
    texts, parameters = entries(SOURCE), _parameters()
    keys = sorted(key for key in texts if key in parameters)
    codes = defaultdict(list)
    for key in keys:
        codes[key.partition(".")[0]].append(key)
    return "\n".join([HEAD, *(line for code in sorted(codes) for line in _section(code, codes[code], parameters))])


def _section(code: str, keys: list[str], parameters: dict[str, list[str]]) -> Iterator[str]:
    yield f"## {code}\n"
    for key in keys:
        entry = entries(SOURCE)[key]
        named = f" ({', '.join(f'`{name}`' for name in parameters[key])})" if parameters[key] else ""
        yield f"- `{key}`{named}: {_plain(entry.message)}{_advice(entry)}"
    yield ""


def _advice(entry: Entry) -> str:
    return "" if entry.advice is None else f" — {_plain(entry.advice)}"


def _plain(text: Text) -> str:
    return " / ".join(text.forms.values()).replace("{{", "{").replace("}}", "}").replace("<", "&lt;")


def _parameters() -> dict[str, list[str]]:
    """Names of the parameters of each key that the code makes messages of."""
    found: dict[str, set[str]] = defaultdict(set)
    for one in all_made():
        found[one.key] |= one.names or set()
    return {key: sorted(names) for key, names in found.items()}


if __name__ == "__main__":
    PATH.parent.mkdir(parents=True, exist_ok=True)
    PATH.write_text(written(), encoding="utf-8")
