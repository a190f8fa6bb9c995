"""Message catalogues: English is written in the code, other languages are read from `locales/*/LC_MESSAGES/*.po`."""

from __future__ import annotations

import gettext
from functools import cache
from io import BytesIO
from pathlib import Path

LOCALES = Path(__file__).parent / "locales"
DOMAIN = "drumtrue"


def N_(text: str) -> str:  # noqa: N802
    """Mark a text for the catalogue; it is translated where it is shown."""
    return text


@cache
def messages(language: str) -> dict[str, str]:
    """Every text of the catalogue of a language with its translation, texts with a plural left out."""
    path = LOCALES / language / "LC_MESSAGES" / f"{DOMAIN}.po"
    if not path.is_file():
        return {}
    # Imported here: the service starts without them.
    from babel.messages.pofile import read_po

    with path.open("rb") as text:
        found = read_po(text, locale=language)
    return {m.id: str(m.string) for m in found if isinstance(m.id, str) and m.id and m.string}


@cache
def translations(language: str) -> gettext.NullTranslations:
    """The catalogue of a language, read once; texts as written for English."""
    path = LOCALES / language / "LC_MESSAGES" / f"{DOMAIN}.po"
    if not path.is_file():
        return gettext.NullTranslations()
    # Imported here: the service starts without them.
    from babel.messages.mofile import write_mo
    from babel.messages.pofile import read_po

    compiled = BytesIO()
    with path.open("rb") as text:
        write_mo(compiled, read_po(text, locale=language))
    compiled.seek(0)
    return gettext.GNUTranslations(compiled)
