"""Uploads from slicers: the parts of Moonraker's and OctoPrint's interfaces that they use.

Nothing here starts motion.
"""
