"""Rank 1. Robots as arrays for the kernels, and the results that kernels compute."""
