"""Kernels of motion along a path: modes that follow the pose, and free vibrations between samples."""
