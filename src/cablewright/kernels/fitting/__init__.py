"""Least squares for calibration and line fits for lidar scans."""
