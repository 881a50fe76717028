"""`drives`: the winches of a real machine, and virtual ones to try everything on."""

from cablewright.apps.cli.drives.command import DrivesCommand

__all__ = ["DrivesCommand"]
