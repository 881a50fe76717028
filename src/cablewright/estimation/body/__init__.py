"""Pose of a rigid platform from its encoders, load cells and inertial unit."""
