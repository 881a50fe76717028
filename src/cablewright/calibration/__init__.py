"""Numbers of a robot's description from measurements."""
