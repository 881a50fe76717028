"""Model of one line from winch to platform; solvers call only the functions of `interface`."""
