"""A machine that people watch and operate from elsewhere: its control, and what goes to and fro."""
