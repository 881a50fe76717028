"""`modulus` and `creep`: stiffness and creep of a cable, from tests of a specimen."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.options import OutputOptions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import numbers, quantity
from cablewright.foundation.errors import InputError, UnknownName

if TYPE_CHECKING:
    from cablewright.foundation.units import Dimension


InitialLength = Annotated[
    str,
    typer.Option(
        "--initial-length",
        metavar="L",
        help="Length of the specimen at elongation zero, in m or with a unit like '2 m'.",
    ),
]


@options("Specimen")
class SpecimenOptions:
    """Options of the specimen; --robot takes section and breaking load from the cable of a robot."""

    section: Annotated[
        str | None,
        typer.Option(
            "--section", metavar="S", help="Area of the cable's cross-section, in m^2 or with a unit like '12.57 mm^2'."
        ),
    ] = None
    diameter: Annotated[
        str | None,
        typer.Option(
            "--diameter",
            metavar="D",
            help="Diameter of the cable, in m or with a unit like '4 mm'; replaces "
            "--section by the area of the full circle.",
        ),
    ] = None
    breaking_load: Annotated[
        str | None,
        typer.Option(
            "--breaking-load", metavar="F", help="Breaking load of the cable, in N or with a unit like '10.29 kN'."
        ),
    ] = None
    robot: Annotated[
        str | None,
        typer.Option(
            "--robot",
            metavar="ROBOT",
            help="Robot whose cable was tested: its section and breaking load, where no other option gives them.",
        ),
    ] = None
    line: Annotated[
        str | None, typer.Option("--line", metavar="NAME", help="Line of --robot whose cable was tested.")
    ] = None

    def section_and_load(self) -> tuple[float, float]:
        """Return the cross-section of the cable, m^2, and its breaking load, N. Raises `InputError`."""
        from cablewright.foundation.units import AREA, FORCE, LENGTH

        if self.section is not None and self.diameter is not None:
            raise InputError(f"--diameter = {self.diameter!r}: give either this or --section, not both")
        if self.robot is None and self.line is not None:
            raise InputError(f"--line = {self.line!r}: give --robot too, the robot that has this line")
        area = _quantity(self.section, "--section", AREA)
        diameter = _quantity(self.diameter, "--diameter", LENGTH)
        area = area if diameter is None else math.pi / 4 * diameter**2
        load = _quantity(self.breaking_load, "--breaking-load", FORCE)
        if self.robot is not None:
            cable = self._cable(self.robot, with_section=area is None, with_load=load is None)
            if area is None and cable.load_section is None:
                reason = "its cable is given by axial_stiffness and has no section; give --section or --diameter"
                raise InputError(f"--robot = {self.robot!r}: {reason}")
            area, load = cable.load_section if area is None else area, cable.breaking_load if load is None else load
        if area is None:
            raise InputError("missing option '--section': give it, or --diameter, or --robot")
        if load is None:
            raise InputError("missing option '--breaking-load': give it, or --robot")
        return area, load

    def _cable(self, robot: str, *, with_section: bool, with_load: bool) -> cw.Cable:
        """The cable of the robot's line; without a name, all lines must have the same cable data."""
        lines = cw.load(robot).lines
        if self.line is not None:
            named = {each.name: each.cable for each in lines}
            if self.line not in named:
                raise UnknownName("line", self.line, named)
            return named[self.line]
        cables = [each.cable for each in lines]
        needed = {
            (each.load_section if with_section else None, each.breaking_load if with_load else None) for each in cables
        }
        if len(needed) > 1:
            raise InputError(f"--robot = {robot!r}: its lines have different cables; name one with --line")
        return cables[0]


@command(
    "modulus examples/tensile.csv --initial-length '2 m' --robot paty2021", "calibration.tensile.modulus:TensileResult"
)
def modulus_command(
    *,
    test: Annotated[Path, typer.Argument(metavar="TEST", help="CSV file with columns force and elongation.")],
    initial_length: InitialLength,
    specimen: SpecimenOptions,
    band: Annotated[
        str,
        typer.Option(
            "--band",
            metavar="MIN,MAX",
            help="Range MIN,MAX of force in which the modulus is fitted, as fractions of the breaking load.",
        ),
    ] = "0.05,0.5",
    output: OutputOptions,
) -> int:
    """The nominal modulus is the secant of the last full loading over a band of the breaking load (Paty 2021, Eq. 22).

    Also prints the range of the modulus over all branches, the hysteresis and the permanent set.
    """
    from cablewright.foundation.units import LENGTH

    length = _quantity(initial_length, "--initial-length", LENGTH)
    assert length is not None
    section, load = specimen.section_and_load()
    found = cw.modulus(test, initial_length=length, section=section, breaking_load=load, band=_band(band))
    return answer(found, output.as_json, **output.write(found, "Young's modulus"))


def _quantity(text: str | None, option: str, dimension: Dimension) -> float | None:
    return None if text is None else quantity(text, option, dimension)


def _band(text: str) -> tuple[float, float]:
    values = numbers(text, "--band") or []
    if len(values) != 2 or not 0 < values[0] < values[1] <= 1:
        raise InputError(f"--band = {text!r}: expected two shares of the breaking load, 0 < MIN < MAX <= 1")
    return values[0], values[1]


@command("creep examples/creep.csv --initial-length '2 m'", "calibration.tensile.creep:CreepResult")
def creep_command(
    *,
    test: Annotated[
        Path,
        typer.Argument(
            metavar="TEST",
            help="CSV file with columns time, force and elongation, and optionally temperature and humidity.",
        ),
    ],
    initial_length: InitialLength,
    retardations: Annotated[
        str,
        typer.Option(
            "--retardations",
            metavar="T,...",
            help="Retardation times of the Voigt elements, in s or with a unit like '1 min'; `none` fits logarithmic "
            "creep alone.",
        ),
    ] = "60,1200",
    output: OutputOptions,
) -> int:
    """Separates stretch and creep by one fit of the whole history of force: a constant load, steps or cycles.

    The law consists of Voigt elements and logarithmic creep, with sigmas. If the climate changes under load, the
    effects of heat and humidity are fitted too.
    """
    from cablewright.foundation.units import DURATION, LENGTH

    length = quantity(initial_length, "--initial-length", LENGTH)
    texts = [] if retardations == "none" else retardations.split(",")
    taus = [quantity(text.strip(), "--retardations", DURATION) for text in texts]
    with progress() as show:
        found = cw.creep(test, initial_length=length, retardations=taus, progress=show)
    return answer(found, output.as_json, **output.write(found, "creep"))
