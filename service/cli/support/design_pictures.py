"""Pictures of design documents for the command line."""

from __future__ import annotations

import time
from typing import Any

from service.design import optimising
from service.errors import InvalidInput
from service.messages import Message
from service.usecases.designs import answers
from service.web.designs.figures import Figures, front_picture
from service.web.pictures.drawing import Picture
from service.web.pictures.reader import Reader
from service.web.preferences import LANGUAGES, Preferences

FRONT = "front"
TIME_LIMIT_S = 120.0


def drawn(
    document: dict[str, Any], before: dict[str, Any] | None, kind: str, points: int, language: str
) -> tuple[str, Picture]:
    """The kind and the picture of a design; an empty kind is the first that the design offers.

    Raises RefusedDesign for a document that breaks a rule, InvalidInput for a kind or language that is not offered.
    """
    if language not in LANGUAGES:
        raise InvalidInput(
            Message("language_unknown", known=tuple(LANGUAGES), value=language), field="language", value=language
        )
    reader = Reader(Preferences(language=language))
    if kind == FRONT:
        found = optimising.front(document, points, clock=time.monotonic, deadline_s=TIME_LIMIT_S)
        return FRONT, front_picture(answers.front_of(found), reader)
    shown = answers.evaluated(document)
    figures = Figures(shown, None if before is None else answers.evaluated(before), reader)
    offered = figures.all()
    chosen = kind or next(iter(offered))
    if chosen not in offered:
        known = (*offered, FRONT) if answers.has_front(document) else tuple(offered)
        raise InvalidInput(Message("design_picture_unknown", known=known, value=kind), field="kind", value=kind)
    return chosen, offered[chosen]
