"""Inverse problem of robots with several lines on one winch drum: tensions and lengths that agree with the drum."""
