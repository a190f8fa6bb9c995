"""Machines, and the influence coefficients that their sessions teach."""
