"""Rank 1. How a robot becomes the arrays that kernels take."""
