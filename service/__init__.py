"""Drumtrue's service: from vibration readings to the masses to bolt on.

The rooms, top to bottom (checked by import-linter, see pyproject.toml):

========== ==================================================================
cli        the command `drumtrue`
app        create_app(settings): lifespan, mounts
api        JSON over HTTP
bootstrap  the only place that builds things
usecases   the verbs of the product, as plain functions over a unit of work
balancing  numerics of balancing: phasors, fit, corrections, rotor, selection
optimize   mixed-variable optimisers that know nothing of drums
========== ==================================================================
"""
