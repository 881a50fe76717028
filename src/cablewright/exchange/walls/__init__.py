"""Robots in the plane of a wall or a board, on two belts from above: read from the settings of their firmwares."""
