"""The commands that find a robot's numbers from measurements."""
