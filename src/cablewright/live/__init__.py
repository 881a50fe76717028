"""Rank 4: a machine that runs: the loop, prints, sessions on drives, messages to the page."""
