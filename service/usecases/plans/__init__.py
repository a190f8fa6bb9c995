"""Corrections and plans of a session: computed, stored, reserved, fitted, taken off."""
