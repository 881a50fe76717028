"""Solvers of a robot's statics (rank 2): one file per question."""
