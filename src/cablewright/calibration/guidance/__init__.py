"""A calibration step by step: which poses to measure next, what is known by now, and when to stop."""
