"""A calibration step by step: which poses to measure next, present knowledge, and when to stop."""
