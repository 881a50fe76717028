"""Logs of machines for ROS 2."""
