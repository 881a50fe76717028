"""Gross errors in the rows of a calibration."""
