"""Rank 4. How the ranks below are put together."""
