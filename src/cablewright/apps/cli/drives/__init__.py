"""`drives`: commands for the winches of a real machine, and for virtual drives."""
