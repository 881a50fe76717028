"""Files of other programs, in and out: one file a format. Nothing here computes; each translates."""
