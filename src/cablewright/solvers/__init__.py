"""Rank 2. Solvers: one file per question about a robot's statics."""
