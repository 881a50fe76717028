"""A part printed in stages, each with other exit points: its check, its seams, and the search for few stages."""
