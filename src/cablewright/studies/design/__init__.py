"""Optimisation of a robot's design for a part: variables, figures, optimisers, and results."""
