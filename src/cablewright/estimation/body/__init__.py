"""Pose of a rigid platform from winch encoders, load cells and an inertial unit."""
