"""Rank 4: how work is run: executors, run folders, memory, keys, resumption."""
