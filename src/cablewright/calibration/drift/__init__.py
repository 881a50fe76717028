"""What moved since a calibration: by a handful of new measurements, or by another calibration."""
