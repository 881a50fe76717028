"""Control (rank 3): commands of the next step from the estimated state. Each part has settings, state and step."""
