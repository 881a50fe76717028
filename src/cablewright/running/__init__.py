"""Running of work (rank 4): executors, run folders, memory, keys, resumption."""
