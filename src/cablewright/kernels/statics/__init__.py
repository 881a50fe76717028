"""Statics of one pose: the lines, the platform, and the forward and inverse problems."""
