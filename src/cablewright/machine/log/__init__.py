"""The machine's log: MCAP files with frames, commands and, of a simulation, the truth."""
