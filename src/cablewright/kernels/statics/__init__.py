"""One pose: the lines, the platform on them, and the forward and inverse problems."""
