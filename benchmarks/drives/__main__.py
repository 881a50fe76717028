"""`python -m benchmarks.drives CYCLES`: how late cycles are, as a histogram."""

from benchmarks.drives.by_clock import main

main()
