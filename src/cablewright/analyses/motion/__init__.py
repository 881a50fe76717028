"""Motion along a path: swing of the platform, and its effect on the lines."""
