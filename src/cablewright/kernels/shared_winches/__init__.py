"""Lines on one drum: tensions and lengths that fit it."""
