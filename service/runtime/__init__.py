"""Plumbing of a running service: idempotency, group commit, solver slots, change feed, metrics, health."""
