"""Commands that estimate a robot's numbers from measurements."""
