"""What a simulated machine has and no model of it: creep, hysteresis, friction, exits that give, backlash, wind."""
