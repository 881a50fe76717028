"""Robots on two belts in the plane of a wall or board: import and export of their firmwares' settings."""
