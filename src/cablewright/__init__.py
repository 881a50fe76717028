"""cablewright models, checks, calibrates and runs cable-driven parallel robots that print large parts.

The names below are the public interface. They are loaded when first used, so that a description alone
(`cablewright.robot`) costs neither Numba nor plotting.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cablewright.errors import AnswerError, CablewrightError, EnvironmentFault, InputError, Status
    from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
    from cablewright.models.statics import Equilibrium, Model
    from cablewright.printing.job import Job, load_job
    from cablewright.robot import Robot, library_names, load, loads
    from cablewright.solvers.forward import Tracker, forward
    from cablewright.solvers.inverse import inverse
    from cablewright.solvers.linearise import Linearisation, linearise
    from cablewright.studies.check import Check, check

__all__ = [
    "AnswerError",
    "CableLaw",
    "CablewrightError",
    "Check",
    "EnvironmentFault",
    "Equilibrium",
    "Fidelity",
    "InputError",
    "Job",
    "Linearisation",
    "Model",
    "Robot",
    "SheaveLaw",
    "Status",
    "Tracker",
    "check",
    "forward",
    "inverse",
    "library_names",
    "linearise",
    "load",
    "load_job",
    "loads",
]

_HOMES = {
    "errors": ("AnswerError", "CablewrightError", "EnvironmentFault", "InputError", "Status"),
    "models.fidelity": ("CableLaw", "Fidelity", "SheaveLaw"),
    "models.statics": ("Equilibrium", "Model"),
    "printing.job": ("Job", "load_job"),
    "robot": ("Robot", "library_names", "load", "loads"),
    "solvers.forward": ("Tracker", "forward"),
    "solvers.inverse": ("inverse",),
    "solvers.linearise": ("Linearisation", "linearise"),
    "studies.check": ("Check", "check"),
}


def __getattr__(name: str) -> object:
    """Load a public name when it is first asked for (PEP 562)."""
    for home, names in _HOMES.items():
        if name in names:
            value = getattr(import_module(f"cablewright.{home}"), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module 'cablewright' has no attribute {name!r}")


def __dir__() -> list[str]:
    """The public names, loaded or not."""
    return sorted(__all__)
