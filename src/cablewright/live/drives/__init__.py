"""Real machines: line lengths kept over a loss of power, sessions with their drives, and prints on them."""
