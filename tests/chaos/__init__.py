"""Tests of the campaign of faults and of the checker of histories."""
