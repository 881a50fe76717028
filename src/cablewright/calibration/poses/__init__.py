"""Calibration from measurements at poses: equations, fits, and what these determine."""
