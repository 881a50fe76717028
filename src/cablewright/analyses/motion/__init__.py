"""Motion along a path: how far the platform swings from it, and what that does to the lines."""
