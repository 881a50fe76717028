"""The simulated machine: the true robot, its plants, and one file a sensor."""
