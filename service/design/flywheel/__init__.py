"""The flywheel study: thickness of a rotating disc over its radius."""
