"""The simulated drum: mechanics, sensors, faults, control port."""
