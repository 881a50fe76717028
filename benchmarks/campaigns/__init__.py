"""Campaigns over many drawn machines, run by hand."""
