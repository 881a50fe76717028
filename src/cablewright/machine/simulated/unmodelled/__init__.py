"""Effects of a simulated machine that models omit: creep, hysteresis, friction, soft mounts, backlash, wind."""
