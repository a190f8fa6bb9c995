"""JSON documents: frozen dataclasses defined once, used on the wire, stored as they are.

Strict everywhere: an unknown field, a NaN, a number given as text or a boolean given as a number is refused. The text
under each field is its description in the API.
"""
