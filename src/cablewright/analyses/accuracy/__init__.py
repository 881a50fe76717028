"""Errors of the nozzle under uncertain parameters of the robot."""
