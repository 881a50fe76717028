"""`serve`: the operator's page of a machine."""

from cablewright.apps.cli.serve.command import ServeCommand

__all__ = ["ServeCommand"]
