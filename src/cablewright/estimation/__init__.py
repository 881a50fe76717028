"""Estimation of the machine's state (pose, lengths, tensions) from its sensors' readings."""
