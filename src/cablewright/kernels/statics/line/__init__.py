"""One line from winch to platform: all its kinds, behind the functions of `interface`."""
