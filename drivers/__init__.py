"""Sources of readings: simulated, and whatever else passes the contract in tests/contract."""
