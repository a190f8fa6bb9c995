"""The rotor and its conventions: phasors, units, reactions, tolerances, labels."""
