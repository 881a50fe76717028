"""Pictures of many variants of a machine: combinations of values, machines as built, candidates of a design."""
