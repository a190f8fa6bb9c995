"""Arrangements of weighed parts on documents, without storage.

=============== =================================================================
request_checks  what a request must satisfy, each refusal with a name
frame           planes, offset and objective of a request in arrays
parts           parts and places of a request in arrays
with_box        stock masses together with parts
answers         an answer as documents: moves in order, residual, maker's rule
solver          a request to an answer, its front, other circumstances
=============== =================================================================
"""

from service.engine.arrangement.request_checks import check_places, check_weighed
from service.engine.arrangement.solver import ArrangementContext, answer, front, mounted, what_if
from service.engine.arrangement.with_box import Box

__all__ = ["ArrangementContext", "Box", "answer", "check_places", "check_weighed", "front", "mounted", "what_if"]
