"""One router per noun; each endpoint calls one use case."""
