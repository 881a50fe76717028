"""Steps of the Kalman filter of a point platform: predictions, updates, and the estimate, over packed states."""
