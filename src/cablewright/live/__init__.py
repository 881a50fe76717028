"""Rank 4: a machine that runs: the loop, prints, sessions on drives, what the page is told."""
