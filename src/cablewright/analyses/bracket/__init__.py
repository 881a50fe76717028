"""Stress in the brackets of the sheaves, by finite elements."""
