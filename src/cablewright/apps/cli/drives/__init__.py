"""`drives`: the winches of a real machine, and virtual ones to try everything on."""
