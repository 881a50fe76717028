"""Changes of a machine since its calibration, found by a few new measurements or by another calibration."""
