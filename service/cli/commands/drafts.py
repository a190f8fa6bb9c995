"""`drumtrue layout` and `drumtrue mapping`: look at a file and write what it needs to be read, to be corrected."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from service.cli.support import can_options

To = Annotated[
    Path | None,
    typer.Option("--to", dir_okay=False, help="File to write it to, which must not exist; default: print it."),
]


def layout(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="Waveform file: CSV, WAV, UFF, LVM, TDMS.")],
    to: To = None,
    started_at: can_options.StartedAt = None,
) -> None:
    """Say what a waveform file holds, and write a layout for it, to be corrected."""
    from drivers.files.layout_draft import described, draft
    from drivers.files.survey import survey

    found = survey(file)
    _write(to, draft(found, file, started_at), described(found, file))


def mapping(
    dbc: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="DBC of another maker's balancer.")],
    to: To = None,
) -> None:
    """Say which messages a DBC holds, and write a mapping for it, to be corrected."""
    from drivers.can.dbc import BrokenDatabase, load_dbc
    from drivers.can.mapping_draft import described, draft
    from drivers.errors import InvalidSetting

    try:
        database = load_dbc(dbc)
    except (OSError, BrokenDatabase) as error:
        raise InvalidSetting(f"{dbc} is no DBC that can be read ({error}): export it again") from error
    _write(to, draft(database, dbc), described(database))


def _write(to: Path | None, text: str, described: list[str]) -> None:
    if to is None:
        print(text, end="")
        return
    from drivers.errors import WRITABLE, LogError

    try:
        with to.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise LogError(to, None, "it is there already", "name a new file: a draft never replaces one") from error
    except OSError as error:
        raise LogError(to, None, f"it cannot be written ({error.strerror})", WRITABLE) from error
    for line in described:
        print(line)
    print(f"written to {to}: correct what is marked there")
