"""Rank 3: what a machine shall do next, from what is believed of it. Settings, state, step."""
