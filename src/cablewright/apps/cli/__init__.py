"""The command line. Its commands, options, JSON and exit codes are a contract."""
