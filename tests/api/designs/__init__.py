"""Tests of design studies over HTTP."""
