"""Machines: what takes a command and answers with what its sensors say. Simulated, or replayed from a log."""
