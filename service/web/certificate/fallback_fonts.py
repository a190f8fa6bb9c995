"""Fonts of the machine for scripts that the certificate's own font has not: found by name, none is shipped.

Chinese, Japanese and Korean fonts are 10 MB each. Where none is installed a box stands for each sign, and the
certificate says so. `DRUMTRUE_FONTS` names one more folder to look in.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from functools import cache
from pathlib import Path

FOLDERS = ("/usr/share/fonts", "/usr/local/share/fonts", "~/.local/share/fonts", "~/.fonts", "/Library/Fonts")
WANTED = (
    "NotoSansSC", "NotoSansTC", "NotoSansJP", "NotoSansKR", "NotoSansHK", "NotoSansCJK", "DroidSansFallback", "wqy",
    "NotoSansDevanagari", "NotoSansBengali", "NotoSansTamil", "NotoSansThai", "NotoSansArabic", "NotoSansHebrew",
    "NotoEmoji", "NotoSansSymbols", "Symbola", "unifont",
)  # fmt: skip
"""Beginnings of file names, in the order in which the fonts are asked."""
_KINDS = {".ttf", ".otf"}


@cache
def installed() -> tuple[Path, ...]:
    """Files of fonts of other scripts, regular ones, the wanted order; looked for once."""
    stated = os.environ.get("DRUMTRUE_FONTS")
    folders = [Path(folder).expanduser() for folder in ((stated,) if stated else ()) + FOLDERS]
    files = [path for folder in folders if folder.is_dir() for path in sorted(folder.rglob("*"))]
    named = [path for path in files if path.suffix.lower() in _KINDS and _is_regular(path)]
    return tuple(path for start in WANTED for path in named if path.name.lower().startswith(start.lower()))


def needed(texts: Iterable[str], known: set[int]) -> tuple[Path, ...]:
    """The installed fonts that have signs of the texts which `known` code points lack."""
    missing = {ord(sign) for text in texts for sign in text} - known
    out = []
    for path in installed():
        if not missing:
            break
        found = missing & _signs(path)
        if found:
            out.append(path)
            missing -= found
    return tuple(out)


def _is_regular(path: Path) -> bool:
    name = path.stem.lower()
    return not any(style in name for style in ("bold", "black", "light", "thin", "medium", "italic"))


@cache
def _signs(path: Path) -> frozenset[int]:
    from fontTools.ttLib import TTFont, TTLibError

    try:
        with TTFont(path, lazy=True) as font:
            return frozenset(font.getBestCmap() or {})
    except (OSError, TTLibError, AttributeError, KeyError):
        return frozenset()
