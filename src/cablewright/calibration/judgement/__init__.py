"""Whether a calibration can be trusted: standard deviations, gross errors, doubts and the verdict."""
