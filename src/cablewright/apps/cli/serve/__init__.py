"""`serve`: the operator's page of a machine."""
