"""Calibration of lines that stretch or sag: their equations, and where their fit starts."""
