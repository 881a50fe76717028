"""Import and export of other programs' files: one file a format. Nothing here computes; each translates."""
