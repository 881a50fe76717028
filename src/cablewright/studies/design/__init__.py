"""A robot designed for its part: variables, figures, optimisers, and what they find."""
