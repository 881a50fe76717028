"""Studies (rank 4): compositions of analyses, solvers and machines that commands run."""
