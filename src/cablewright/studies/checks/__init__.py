"""`check`: a sliced part on a robot, and one verdict."""
