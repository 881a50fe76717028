"""Rank 3: commands of the next step, from the estimated state of the machine. Each part has settings, state, step."""
