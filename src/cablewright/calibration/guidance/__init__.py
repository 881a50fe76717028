"""Guided calibration: which poses to measure next, present knowledge, and when to stop."""
