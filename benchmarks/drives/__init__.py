"""Prints on virtual CANopen drives: by the clock, and beside the plant itself."""

from benchmarks.drives.by_clock import FULL, QUICK, rows

__all__ = ["FULL", "QUICK", "rows"]
