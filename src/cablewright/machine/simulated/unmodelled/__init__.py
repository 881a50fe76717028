"""Effects of a simulated machine that no model has: creep, hysteresis, friction, soft mounts, backlash, wind."""
