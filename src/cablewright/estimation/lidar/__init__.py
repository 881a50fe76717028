"""Planar lidars: scans, the lines in them, and where in a room of known walls the lidar is."""
