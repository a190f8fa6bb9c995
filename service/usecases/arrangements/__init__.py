"""Arrangements of weighed parts: proposed, mounted; sets of places and the history of parts of a machine."""
