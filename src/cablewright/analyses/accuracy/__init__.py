"""How far off the nozzle is while numbers of the robot are uncertain."""
