"""Workspace of a robot: criteria, volumes, surfaces, boundaries and retraction laws."""
