"""`drumtrue replay --compare`: old sessions solved again with today's code, and every answer that changed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

from service.errors import InvalidInput

TOLERANCE = 1e-6
"""What the arithmetic of another processor or library may change, with room."""


@dataclass(frozen=True)
class Compared:
    """One log solved again. changed: answers that are not those of the log. error: why it could not be solved."""

    path: str
    answers: int
    changed: tuple[str, ...] = ()
    error: str | None = None


def compare_folder(
    folder: Path, say: Callable[[str], None], workers: int | None = None, tolerance: float = TOLERANCE
) -> list[Compared]:
    """Solve every session log (*.json) below a folder again, on all cores; progress and changes are said as they come.

    tolerance: relative to the greatest of its kind in the answer, how near a value is the same.
    Raises InvalidInput for a folder without any.
    """
    paths = sorted(str(path) for path in folder.rglob("*.json"))
    if not paths:
        raise InvalidInput(
            f"{folder} holds no session log (*.json)", field="folder", value=str(folder), advice="check the folder"
        )
    found = []
    for done, one in enumerate(_solved(paths, workers or os.cpu_count() or 1, tolerance), 1):
        found.append(one)
        verdict = one.error or (f"{len(one.changed)} changed" if one.changed else "same")
        say(f"[{done}/{len(paths)}] {one.path}: {one.answers} answers, {verdict}")
        for line in one.changed:
            say(f"  {line}")
    return sorted(found, key=lambda one: one.path)


def summary(found: Sequence[Compared]) -> str:
    """All in one line."""
    changed, broken = sum(bool(one.changed) for one in found), sum(one.error is not None for one in found)
    answers = sum(one.answers for one in found)
    return f"{len(found)} sessions, {answers} answers: {changed} sessions changed, {broken} could not be solved"


def compare_one(path: str, tolerance: float = TOLERANCE) -> Compared:
    """Solve one log again; whatever is wrong with it is told, not raised."""
    from service.errors import DrumtrueError
    from service.usecases.resolving import read_log, resolve

    try:
        log = read_log(Path(path).read_bytes())
        resolved = resolve(log, tolerance=tolerance)
    except DrumtrueError as error:
        return Compared(path, 0, error=f"cannot be solved: {error.message}")
    except (OSError, RecursionError) as error:
        return Compared(path, 0, error=f"cannot be read: {error}")
    return Compared(path, len(log.corrections) + len(log.plans), resolved.changed)


def _solved(paths: Sequence[str], workers: int, tolerance: float) -> Iterator[Compared]:
    if len(paths) == 1 or workers == 1:
        yield from (compare_one(path, tolerance) for path in paths)
        return
    # A fresh process each: the numerics' threads and a forked lock do not go together.
    with ProcessPoolExecutor(min(workers, len(paths)), mp_context=get_context("spawn")) as pool:
        for future in as_completed([pool.submit(compare_one, path, tolerance) for path in paths]):
            yield future.result()
