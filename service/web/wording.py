"""What use cases say - findings, refusals, advice - as sentences in the reader's language."""

from __future__ import annotations


def words(told: str, language: str) -> str:  # noqa: ARG001
    """The text as a sentence."""
    told = told.strip()
    return told[:1].upper() + told[1:]
