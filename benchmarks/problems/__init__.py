"""The named problems: where their answers are from, and how other programs solve them."""
