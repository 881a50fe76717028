"""Rank 2. One file per question to a robot."""
