"""`creep`: what a cable creeps by, from a test in which a load is held or cycled."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import OutputOptions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import quantity


@dataclass(frozen=True, kw_only=True)
class CreepCommand:
    """Stretch and creep are told apart by one fit of the whole history of force: a held load, steps or cycles.

    The law is that of Voigt elements and logarithmic creep; what it creeps by after which time is given with sigmas.
    Where the climate changes under load, so is how much faster it creeps when warmer or damper.
    """

    EXAMPLE: ClassVar = "creep examples/creep.csv --initial-length '2 m'"
    ANSWERS: ClassVar = ("calibration.tensile.creep:CreepResult",)

    test: Annotated[
        Path,
        typer.Argument(metavar="TEST", help="CSV file: time, force, elongation, maybe temperature and humidity."),
    ]
    initial_length: Annotated[
        str,
        typer.Option(
            "--initial-length", metavar="L", help="Length of the specimen at elongation zero: m, or like '2 m'."
        ),
    ]
    retardations: Annotated[
        str,
        typer.Option(
            "--retardations",
            metavar="T,...",
            help="Retardation times of the Voigt elements: s, or like '1 min'; none for logarithmic creep alone.",
        ),
    ] = "60,1200"
    output: OutputOptions

    def run(self) -> int:
        """Evaluate the test, draw and print."""
        from cablewright.calibration.tensile.creep import creep
        from cablewright.units import DURATION, LENGTH

        length = quantity(self.initial_length, "--initial-length", LENGTH)
        texts = [] if self.retardations == "none" else self.retardations.split(",")
        taus = [quantity(text.strip(), "--retardations", DURATION) for text in texts]
        with progress() as show:
            found = creep(self.test, initial_length=length, retardations=taus, progress=show)
        return answer(found, self.output.as_json, **self.output.write(found, "creep"))
