"""A cable's modulus from a tensile test."""
