"""Planar lidars: scans, the straight lines in them, and the lidar's position in a room of known walls."""
