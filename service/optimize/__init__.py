"""Optimisers for mixed variables (continuous, integer, discrete) that know nothing of drums."""
