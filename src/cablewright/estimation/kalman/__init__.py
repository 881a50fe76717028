"""The error-state Kalman filter: predict, and one update for each kind of sensor."""
