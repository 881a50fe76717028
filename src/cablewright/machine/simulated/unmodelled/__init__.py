"""What a simulated machine has and no model of it: creep, hysteresis, friction, exit points that give, backlash,
wind."""
