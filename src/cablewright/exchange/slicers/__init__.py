"""Printer profiles for slicers, from the reach and the speed limits of a robot."""
