"""What a solver that stops now and then makes in the end."""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeVar

Made = TypeVar("Made")


def finished(steps: Generator[object, None, Made]) -> Made:
    """Result of a generator, what it yields on the way passed over."""
    while True:
        try:
            next(steps)
        except StopIteration as done:
            made: Made = done.value
            return made
