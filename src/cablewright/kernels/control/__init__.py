"""Computations of one step of the control loop: target on the path, rates of the cable lengths."""
