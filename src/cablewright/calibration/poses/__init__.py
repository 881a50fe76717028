"""Calibration from measurements at poses: equations, fits, and observability."""
