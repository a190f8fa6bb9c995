"""Bases of what is opened and closed or used in a with block: drivers, spools, ports, files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from types import TracebackType
from typing import Self


class Closeable(ABC):
    """Something that is open from its making and closed at the end of a with block."""

    @abstractmethod
    def close(self) -> None:
        """Let go; harmless when closed."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class Openable(Closeable):
    """Something that is opened by a with block, or by `open`."""

    @abstractmethod
    def open(self) -> None:
        """Take hold."""

    def __enter__(self) -> Self:
        self.open()
        return self
