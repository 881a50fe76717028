"""Proofs about equilibria by interval arithmetic: existence, uniqueness, enclosures, exhaustive search."""
