"""The operator's page: a server of its own process, beside the control."""
