"""The simulated machine in motion: platform dynamics, winches, lidar rays."""
