"""Analyses of a robot and its job (rank 3): accuracy, workspace, brackets, limits, interference, vibration."""
