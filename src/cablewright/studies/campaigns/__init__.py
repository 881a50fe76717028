"""Print campaigns: the same print on many simulated machines, built within the tolerances."""
