"""The printed part and the nozzle's motion: G-code, path, time law, layers. Knows no cable and no robot."""
