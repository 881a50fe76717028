"""`check`: whether a robot can print a sliced part, with one verdict."""
