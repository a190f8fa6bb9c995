"""Balancers on a CAN bus: frames, mappings, decoding, logs."""
