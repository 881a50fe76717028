"""Rank 3. What can be said of a robot and a job."""
