"""`drumtrue replay --compare`: old sessions solved again with today's code, and every answer that changed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path

from service.batch.executors import executor
from service.errors import InvalidInput
from service.messages import Message

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
    folder: Path,
    say: Callable[[str], None],
    workers: int | None = None,
    tolerance: float = TOLERANCE,
    cluster: str | None = None,
) -> list[Compared]:
    """Solve every session log (*.json) below a folder again; progress and changes are said as they come.

    tolerance: relative to the greatest of its kind in the answer, how near a value is the same. workers, cluster: where
    it runs, all cores by default. Raises InvalidInput for a folder without any, and what `executor` raises.
    """
    paths = sorted(str(path) for path in folder.rglob("*.json"))
    if not paths:
        raise InvalidInput(
            Message("invalid_input.folder_without_logs", folder=folder), field="folder", value=str(folder)
        )
    found = []
    with executor(1 if len(paths) == 1 else workers, cluster) as where:
        # The text goes along: another machine has no such file.
        work = [where.submit(compare_text, path, _text(path), tolerance) for path in paths]
        for done, future in enumerate(as_completed(work), 1):
            one: Compared = future.result()
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
    return compare_text(path, _text(path), tolerance)


def compare_text(path: str, text: bytes | str, tolerance: float = TOLERANCE) -> Compared:
    """Solve a log again from its bytes; a text instead is why the file could not be read."""
    from service.engine.logs.replay import read_log, resolve
    from service.errors import DrumtrueError

    if isinstance(text, str):
        return Compared(path, 0, error=f"cannot be read: {text}")
    try:
        log = read_log(text)
        resolved = resolve(log, tolerance=tolerance)
    except DrumtrueError as error:
        return Compared(path, 0, error=f"cannot be solved: {error.message}")
    except RecursionError as error:
        return Compared(path, 0, error=f"cannot be read: {error}")
    return Compared(path, len(log.corrections) + len(log.plans), resolved.changed)


def _text(path: str) -> bytes | str:
    try:
        return Path(path).read_bytes()
    except OSError as error:
        return str(error)
