"""Rank 0: what every room stands on: errors, units, arrays, results, files, signals."""
