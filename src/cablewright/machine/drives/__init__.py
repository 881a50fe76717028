"""Winches of a real machine, on CANopen drives: their bus, their states, and the machine made of them."""
