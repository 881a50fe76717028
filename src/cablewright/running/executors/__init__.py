"""Executors: many calls of one function, here, in processes or on a cluster, with results stored on disk."""
