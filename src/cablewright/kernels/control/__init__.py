"""Steps of the control loop."""
