"""A file of heads, kept where who can write to the database cannot: shows that no end of the history was cut off.

Each line is a time, a head and, with a key, an HMAC-SHA-256 over the line before and this one. Without a key the file
is as good as the place it is kept at; with one, only who has the key can write a line.
"""

from __future__ import annotations

import hmac
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from pathlib import Path

from service.errors import Conflict, InvalidInput
from service.messages import Message

MIN_KEY_BYTES = 32


@dataclass(frozen=True)
class Heads:
    """The file, and the key that signs its lines where there is one."""

    path: Path
    key: bytes | None = None

    def last(self) -> str | None:
        """The head that was written last; None for a new file. Raises Conflict for a line whose signature is wrong."""
        before, head = "", None
        for number, line in enumerate(self._lines(), 1):
            _, head, signature = (*line.split(), "", "", "")[:3]
            if self.key is not None and not hmac.compare_digest(
                signature, self._signed(before, line.rsplit(" ", 1)[0])
            ):
                raise Conflict(
                    Message("head_forged", number=number, path=self.path), field="--head-to", value=line[:100]
                )
            before = line
        return head

    def append(self, head: str, now: datetime) -> None:
        """Write a head. Raises InvalidInput where the file cannot be written."""
        before = (["", *self._lines()])[-1]
        line = f"{now.isoformat()} {head}"
        if self.key is not None:
            line += f" {self._signed(before, line)}"
        try:
            with self.path.open("a", encoding="ascii") as out:
                out.write(line + "\n")
        except OSError as wrong:
            raise InvalidInput(
                Message("invalid_input.heads_not_written", path=self.path, reason=wrong.strerror),
                field="--head-to",
                value=str(self.path),
            ) from wrong

    def _lines(self) -> list[str]:
        try:
            return self.path.read_text(encoding="ascii").splitlines()
        except FileNotFoundError:
            return []
        except (OSError, UnicodeError) as wrong:
            raise InvalidInput(
                Message("invalid_input.heads_unreadable", path=self.path, reason=wrong),
                field="--head-to",
                value=str(self.path),
            ) from wrong

    def _signed(self, before: str, line: str) -> str:
        return hmac.new(self.key or b"", f"{before}\n{line}".encode(), sha256).hexdigest()


def key_from(path: Path | None) -> bytes | None:
    """The key in a file. Raises InvalidInput where there are too few bytes of it."""
    if path is None:
        return None
    key = path.read_bytes().strip()
    if len(key) < MIN_KEY_BYTES:
        raise InvalidInput(
            Message("invalid_input.head_key", size=len(key), least=MIN_KEY_BYTES), field="--head-key", value=len(key)
        )
    return key
