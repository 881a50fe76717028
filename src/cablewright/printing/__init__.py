"""The part and the motion: G-code, the path of the nozzle, its time law, its layers. Knows no cable and no robot."""
