"""Equations of each kind of calibration measurement: rows by the unknowns, and their sigmas."""
