"""Dynamics of the simulated machine: platform, winches, line vibration, lidar rays."""
