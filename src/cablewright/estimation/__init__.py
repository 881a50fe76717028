"""Estimation of a machine's state from its sensors' readings."""
