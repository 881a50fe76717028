"""The operator's page: a web server in its own process, beside the control."""
