"""Messages as data: a key of the catalogue with named parameters, rendered where somebody reads it.

========= ================================================================
message   `Message` and the kinds of parameter: quantity, part, word, list
as_json   messages in stored documents and answers, and back
catalogue the texts of each language, `texts/<language>/*.toml`
rendering a message as a sentence for a reader
========= ================================================================
"""

from service.messages.as_json import from_json, parameters_json
from service.messages.message import Message, Parameter, Part, Quantity, Word
from service.messages.rendering import ENGLISH, Reader, render, render_advice

__all__ = [
    "ENGLISH",
    "Message",
    "Parameter",
    "Part",
    "Quantity",
    "Reader",
    "Word",
    "from_json",
    "parameters_json",
    "render",
    "render_advice",
]
