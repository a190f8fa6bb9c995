"""Readings from bridges: routed, stored, averaged into runs, rolled up; balancers' answers."""
