"""Rank 3. Analyses of a robot and its job: accuracy, workspace, brackets, limits, interference and vibration."""
