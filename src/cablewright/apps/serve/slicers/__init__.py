"""Upload from slicers: the part of Moonraker's and OctoPrint's interfaces that they use. Nothing here starts motion."""
