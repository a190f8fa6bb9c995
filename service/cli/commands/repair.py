"""`drumtrue repair`: what is stored and cannot be read, and what of it was mended."""

from __future__ import annotations

from service import bootstrap
from service.cli.support.files import counted
from service.settings import Settings
from service.usecases.repair import repair


def repair_database(database_url: str | None, *, mend: bool) -> int:
    """Print what was mended and what cannot be read; 0 where everything can be read now, else 1."""
    work = bootstrap.build_work(Settings.from_environment(database_url=database_url), create=False)
    try:
        found = repair(work, mend=mend)
    finally:
        work.database.close()
    for kind, key in found.mended:
        print(f"mended: {kind} {key}: a scatter that was rounding error is unknown now")
    for part in found.unreadable:
        got = "" if part.value is None else f", got {part.value}"
        print(f"cannot be read: {part.kind} {part.key}: {part.field}: {part.rule}{got}")
    left = counted(len(found.unreadable), "unreadable document")
    if mend:
        print(f"{counted(len(found.mended), 'document')} mended, {left} left")
    else:
        print(f"{left}, nothing was changed")
    if found.unreadable:
        print("each is set apart, everything else goes on; restore the last backup that has it, or leave it as it is")
    return 1 if found.unreadable else 0
