"""Whether a calibration may be trusted: sigmas, gross errors, doubts and the verdict."""
