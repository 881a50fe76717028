"""A print in closed loop: its plan, its loop, its run folder and its record."""
