"""Guided calibration: which poses to measure next, what is known so far, and when to stop."""
