"""Design studies: a document of a machine in, responses, optima and verdicts out; no storage, no clock.

A study is data and four functions: check, simulate, problem and verdict (`study`). Documents are plain tables with
units (`documents`, `reading`); inside everything is in SI.
"""
