"""`modulus`: a cable's Young's modulus from a tensile test."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from cablewright.apps.cli.options import AsJson, Plot, check_plot
from cablewright.apps.cli.output import numbers, print_json, tell
from cablewright.errors import InputError, UnknownName

if TYPE_CHECKING:
    from cablewright.calibration.tensile.result import TensileResult
    from cablewright.robot import Cable
    from cablewright.units import Dimension


def modulus(
    test: Annotated[Path, typer.Argument(metavar="TEST", help="CSV with columns force and elongation.")],
    initial_length: Annotated[
        str,
        typer.Option("--initial-length", metavar="L", help="Specimen at elongation zero: m, or a text like '2 m'."),
    ],
    section: Annotated[str | None, typer.Option("--section", metavar="S", help="m^2, or like '12.57 mm^2'.")] = None,
    diameter: Annotated[
        str | None, typer.Option("--diameter", metavar="D", help="Instead: the section is the full circle of it.")
    ] = None,
    breaking_load: Annotated[
        str | None, typer.Option("--breaking-load", metavar="F", help="N, or like '10.29 kN'.")
    ] = None,
    robot: Annotated[
        str | None, typer.Option("--robot", metavar="ROBOT", help="Takes section and breaking load from its cable.")
    ] = None,
    line: Annotated[str | None, typer.Option("--line", metavar="NAME", help="The robot's line.")] = None,
    band: Annotated[
        str, typer.Option("--band", metavar="LOW,HIGH", help="Shares of the breaking load that the modulus spans.")
    ] = "0.05,0.5",
    plot: Plot = None,
    as_json: AsJson = False,
) -> int:
    """Young's modulus of a cable from a tensile test, how far it varies, and its hysteresis."""
    from cablewright.calibration.tensile.modulus import modulus as judged

    check_plot(plot)
    length = _length(initial_length)
    cable = _specimen(section, diameter, breaking_load, robot, line)
    found = judged(test, initial_length=length, **cable._asdict(), band=_band(band))
    if plot is not None:
        found.plot(plot)
    if as_json:
        print_json(found.to_dict() | {"plot": None if plot is None else str(plot)})
    else:
        _print(found, plot)
    for note in found.notes:
        tell(f"note: {note}")
    return 0


class _Cable(NamedTuple):
    section: float  # m^2
    breaking_load: float  # N


def _specimen(
    section: str | None, diameter: str | None, breaking_load: str | None, robot: str | None, line: str | None
) -> _Cable:
    """Section and breaking load from the options, and from the robot's cable what these do not give."""
    from cablewright.units import AREA, FORCE, LENGTH

    if section is not None and diameter is not None:
        raise InputError(f"--diameter = {diameter!r}: give either this or --section, not both")
    if robot is None and line is not None:
        raise InputError(f"--line = {line!r}: there is no --robot that it could be a line of")
    area = None if section is None else _quantity(section, "--section", AREA)
    if diameter is not None:
        area = math.pi / 4 * _quantity(diameter, "--diameter", LENGTH) ** 2
    load = None if breaking_load is None else _quantity(breaking_load, "--breaking-load", FORCE)
    if robot is not None:
        cable = _cable(robot, line, section=area is None, breaking_load=load is None)
        if area is None and cable.section is None:
            reason = "its cable is given by axial_stiffness and has no section; give --section or --diameter"
            raise InputError(f"--robot = {robot!r}: {reason}")
        area = cable.section if area is None else area
        load = cable.breaking_load if load is None else load
    if area is None:
        raise InputError("missing option '--section': give it, or --diameter, or --robot")
    if load is None:
        raise InputError("missing option '--breaking-load': give it, or --robot")
    return _Cable(area, load)


def _cable(robot: str, line: str | None, section: bool, breaking_load: bool) -> Cable:
    """The cable of the robot's line; without a name, all lines must agree in what is wanted of it."""
    from cablewright.robot import load

    lines = load(robot).lines
    if line is not None:
        named = {each.name: each.cable for each in lines}
        if line not in named:
            raise UnknownName("line", line, named)
        return named[line]
    cables = [each.cable for each in lines]
    kinds = {(each.section if section else None, each.breaking_load if breaking_load else None) for each in cables}
    if len(kinds) > 1:
        raise InputError(f"--robot = {robot!r}: its lines have different cables; name one with --line")
    return cables[0]


def _quantity(text: str, option: str, dimension: Dimension) -> float:
    """A positive quantity of an option: a number in SI or a text with a unit. Raises `InputError`."""
    try:
        value = dimension.read(_plain(text))
    except ValueError as error:
        raise InputError(f"{option} = {text!r}: {error}") from None
    if not value > 0:
        raise InputError(f"{option} = {text!r}: must be over 0")
    return value


def _plain(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


def _length(text: str) -> float:
    from cablewright.units import LENGTH

    return _quantity(text, "--initial-length", LENGTH)


def _band(text: str) -> tuple[float, float]:
    values = numbers(text, "--band") or []
    if len(values) != 2 or not 0 < values[0] < values[1] <= 1:
        raise InputError(f"--band = {text!r}: two shares of the breaking load are wanted, 0 < LOW < HIGH <= 1")
    return values[0], values[1]


def _print(found: TensileResult, plot: Path | None) -> None:
    """The figures for people, and what to do with them."""
    from cablewright.units import AREA, FORCE

    low, high = found.band
    (softest, stiffest), (slowest, steepest) = found.branch_factors, found.tangent_factors
    typer.echo(
        f"modulus        {found.modulus / 1e9:.4g} GPa, from {100 * low:g} to {100 * high:g} % of the breaking load, "
        "last loading"
    )
    typer.echo(f"stiffness EA   {found.axial_stiffness / 1e3:.4g} kN")
    typer.echo(f"stretch        {found.stretch * 1e3:.4g} mm of {found.length:.6g} m, R^2 {found.r_squared:.4f}")
    typer.echo(f"loadings       {_listed(found.loading, 1e-9)} GPa")
    typer.echo(f"unloadings     {_listed(found.unloading, 1e-9)} GPa")
    typer.echo(f"hysteresis     {_listed(found.hysteresis, 100.0, '.1f')} % of the work of loading")
    typer.echo(f"permanent set  {_listed(found.permanent_set, 1e3, '.3f')} mm from one loading to the next")
    typer.echo(f"branches       {softest:.3f} to {stiffest:.3f} times the modulus")
    typer.echo(f"tangents       {slowest:.3f} to {steepest:.3f} times the modulus")
    factors = "{:.2f},{:.2f}".format(*found.modulus_range)
    typer.echo("\nfor the robot file, [cable]:")
    typer.echo(f'young_modulus = "{found.modulus / 1e9:.4g} GPa"')
    typer.echo(f'section = "{AREA.write(found.section, "mm^2")}"')
    typer.echo(f'breaking_load = "{FORCE.write(found.breaking_load, "kN")}"')
    typer.echo(f"\nfor cablewright accuracy: --modulus-range {factors}  ({_against_paper(found.modulus_range)})")
    if plot is not None:
        typer.echo(f"picture        {plot}")


def _listed(values: tuple[float, ...], scale: float, form: str = ".4g") -> str:
    """The first and the last few of a list, times ``scale``, in the format ``form``."""
    shown = [format(scale * value, form) for value in values]
    if len(shown) > 8:
        shown = [*shown[:3], "..", *shown[-4:]]
    return "  ".join(shown) or "-"


def _against_paper(factors: tuple[float, float]) -> str:
    from cablewright.calibration.tensile.modulus import PAPER_SPREAD

    low, high = 1 - PAPER_SPREAD, 1 + PAPER_SPREAD
    kind = "within" if low <= factors[0] and factors[1] <= high else "wider than"
    return f"{kind} {low:g} to {high:g}"
