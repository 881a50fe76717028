"""Robots as arrays for the kernels, and the results of kernels as values (rank 1)."""
