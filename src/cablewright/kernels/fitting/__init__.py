"""Least squares and line fits for calibration and lidar scans."""
