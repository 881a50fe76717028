"""A part that is printed in stages, each with other exit points: its check, its seams, and the fewest stages."""
