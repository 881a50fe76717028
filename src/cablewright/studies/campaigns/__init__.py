"""The same print on many machines that the tolerances allow."""
