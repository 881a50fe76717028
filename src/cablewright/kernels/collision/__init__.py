"""Signed distances of sagging lines from each other, the platform, the frame and a part."""
