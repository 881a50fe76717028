"""Steps of estimators over packed states: a Kalman filter of a point platform, reckoning by encoders, bodies."""
