"""Many calls of one function, here, in processes or on a cluster, with results kept on disk."""
