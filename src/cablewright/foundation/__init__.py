"""Foundation (rank 0) of all other folders: errors, units, arrays, results, files, signals."""
