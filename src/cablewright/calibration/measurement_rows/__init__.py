"""What each kind of measurement says of the unknowns: its rows and their sigmas."""
