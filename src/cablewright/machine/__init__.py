"""Machines, which take commands and return sensor readings: the interface, the simulated one, and logs."""
