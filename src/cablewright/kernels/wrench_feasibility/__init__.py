"""Straight, massless lines: structure matrix, tension distributions, margins."""
