"""Straight, massless lines: structure matrix, tension distributions and margins."""
