"""Errors, findings and other messages as sentences in the reader's language and units."""

from __future__ import annotations

from typing import Protocol

from service.messages import Message, render, render_advice
from service.model.message import MessageData
from service.web.display import Display


class Stated(Protocol):
    """An error or a finding: as data, and in English."""

    @property
    def data(self) -> Message | None:
        """Key and values; None in what an earlier version stored without them."""

    @property
    def message(self) -> str:
        """What is wrong."""

    @property
    def advice(self) -> str | None:
        """What to do."""


def sentence(message: str | Message | MessageData | None, show: Display) -> str:
    """A message as a sentence that begins with a capital letter, without a full stop; a stored text as it is."""
    if message is None or isinstance(message, str):
        return _capital((message or "").strip())
    return _capital(render(message.message if isinstance(message, MessageData) else message, show))


def advice_of(stated: Stated, show: Display) -> str:
    """The advice of an error or a finding as sentences, the last with its full stop too."""
    found = stated.advice if stated.data is None else render_advice(stated.data, show)
    text = _capital(found or "")
    return text if text[-1:] in ("", ".", "!", "?") else f"{text}."


def message_of(stated: Stated, show: Display) -> str:
    """The message of an error or a finding as a sentence."""
    return sentence(stated.data or stated.message, show)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
