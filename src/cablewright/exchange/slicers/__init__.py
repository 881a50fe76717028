"""Printer profiles for slicers, from what a robot reaches and how fast it may move."""
