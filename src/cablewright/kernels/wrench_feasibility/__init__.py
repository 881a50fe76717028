"""Wrench feasibility with straight, massless lines: structure matrix, tension distributions, margins."""
