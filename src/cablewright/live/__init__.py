"""A running machine (rank 4): control loop, prints, sessions on drives, messages to the operator's page."""
