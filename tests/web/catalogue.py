"""The texts of the pages and their translations; `python -m tests.web.catalogue` brings the catalogues up to date.

New texts are added without a translation, texts that are gone are dropped; `test_language` fails until all are
translated.
"""

from __future__ import annotations

from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import extract_from_dir
from babel.messages.pofile import read_po, write_po

from service.web.language import DOMAIN, LOCALES

ROOM = LOCALES.parent
METHODS = [("templates/**.html", "jinja2"), ("**.py", "python")]
KEYWORDS = {"_": None, "gettext": None, "ngettext": (1, 2), "N_": None}
OPTIONS = {"templates/**.html": {"extensions": "jinja2.ext.do", "trimmed": "true", "silent": "false"}}

HEADER = """\
msgid ""
msgstr ""
"MIME-Version: 1.0\\n"
"Content-Type: text/plain; charset=utf-8\\n"
"Content-Transfer-Encoding: 8bit\\n"
"Plural-Forms: nplurals=2; plural=(n != 1);\\n"

"""


def extracted() -> Catalog:
    """Every text of code and templates."""
    found = Catalog(charset="utf-8")
    for name, line, message, _comments, context in extract_from_dir(ROOM, METHODS, OPTIONS, KEYWORDS):
        found.add(message, None, [(Path(name).as_posix(), line)], context=context)
    return found


def path_of(language: str) -> Path:
    """Where the catalogue of a language lies."""
    return LOCALES / language / "LC_MESSAGES" / f"{DOMAIN}.po"


def stored(language: str) -> Catalog:
    """The catalogue of a language as it lies in the repository."""
    with path_of(language).open("rb") as text:
        return read_po(text, locale=language)


def update(language: str) -> list[str]:
    """Write the catalogue again with today's texts; returns those that still need a translation."""
    path = path_of(language)
    before = {message.id: message.string for message in stored(language) if message.id} if path.is_file() else {}
    catalogue = Catalog(locale=language, charset="utf-8")
    for message in extracted():
        if message.id:
            catalogue.add(message.id, before.get(message.id))
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as text:
        text.write(HEADER.encode())
        write_po(text, catalogue, width=118, sort_output=True, omit_header=True)
    return untranslated(catalogue)


def untranslated(catalogue: Catalog) -> list[str]:
    """Texts without a translation, in all their numbers."""
    return [
        str(m.id) for m in catalogue if m.id and not (all(m.string) if isinstance(m.string, tuple | list) else m.string)
    ]


if __name__ == "__main__":
    for text in update("de"):
        print(f"untranslated: {text}")  # noqa: T201
