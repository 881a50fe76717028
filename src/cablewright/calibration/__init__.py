"""Calibration: values of a robot's geometry, cables and sensors, estimated from measurements."""
