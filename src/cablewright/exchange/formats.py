"""Table of formats by name: which can be read or written, and how a file's format is recognised."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final

from cablewright.exchange import caspr, klipper_config, maslow, rrf_config, wirex, xml_input
from cablewright.exchange.translation_result import ImportedRobot, Mapped
from cablewright.exchange.walls import fluidnc, maslow_classic, polargraph
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.toml_input import read_bytes


@dataclass(frozen=True)
class ImportOptions:
    """Choices of an import.

    ``cable``: one of the table of cables; ``cable_set``: set of cables to read from a CASPR model. ``nozzle_below``: m,
    of the nozzle of a Hangprinter below the point where its lines meet.
    """

    cable: str | None = None
    cable_set: str | None = None
    nozzle_below: float = 0.0


@dataclass(frozen=True)
class ReadFormat:
    """A format that can be read: its title, file endings, number of files, and carried values.

    ``begins``: what a line of such a file begins with, or follows a tag, in no other format: a regular expression.
    """

    title: str
    endings: tuple[str, ...]
    most_files: int
    carried: tuple[Mapped, ...]
    begins: str
    read: Callable[[Sequence[Path], ImportOptions], ImportedRobot]


READ: Final[Mapping[str, ReadFormat]] = MappingProxyType({
    "wirex": ReadFormat(
        "WireX", (".wcrfx",), 1, wirex.CARRIED, r"<models\b",
        lambda paths, o: wirex.read_wirex(paths[0], o.cable),
    ),
    "caspr": ReadFormat(
        "CASPR", (".xml",), 2, caspr.CARRIED, r"<(links|bodies_system|cables)\b",
        lambda paths, o: caspr.read_caspr(paths, o.cable_set, o.cable),
    ),
    "maslow": ReadFormat(
        "Maslow", (".yaml", ".yml"), 1, maslow.CARRIED, r"maslow_|maslowkinematics *:",
        lambda paths, o: maslow.read_maslow(paths[0], o.cable),
    ),
    "wallplotter": ReadFormat(
        "FluidNC's WallPlotter", (".yaml",), 1, fluidnc.CARRIED, r"wallplotter *:",
        lambda paths, o: fluidnc.read_wall_plotter(paths[0], o.cable),
    ),
    "maslow-classic": ReadFormat(
        "classic Maslow", (".ini", ".txt"), 1, maslow_classic.CARRIED,
        r"motorspacingx *[=:]|\$2 *=[^\n]{0,99}\(distance between",
        lambda paths, o: maslow_classic.read_maslow_classic(paths[0], o.cable),
    ),
    "polargraph": ReadFormat(
        "Marlin's polargraph", (".h", ".gcode"), 1, polargraph.CARRIED,
        r"# *define +polargraph\b(?!_)|(?:echo: *)?m665\b(?=[^\n;]{0,200} t)(?=[^\n;]{0,200} l)(?=[^\n;]{0,200} b)",
        lambda paths, o: polargraph.read_polargraph(paths[0], o.cable),
    ),
    "makelangelo": ReadFormat(
        "Makelangelo", (".gcode",), 1, polargraph.OF_MAKELANGELO, r"m101 +a[01]\b",
        lambda paths, o: polargraph.read_makelangelo(paths[0], o.cable),
    ),
    "klipper": ReadFormat(
        "Klipper", (".cfg",), 1, klipper_config.CARRIED, r"\[(printer|stepper_a)\]",
        lambda paths, o: klipper_config.read_klipper(paths[0], o.cable, o.nozzle_below),
    ),
    "reprapfirmware": ReadFormat(
        "RepRapFirmware", (".g",), 1, rrf_config.CARRIED, r"(?:n\d+ +)?m669(?!\d)",
        lambda paths, o: rrf_config.read_rrf(paths[0], o.cable, o.nozzle_below),
    ),
})  # fmt: skip
"""Formats of robots that are read, by name."""


def read_robot(paths: Sequence[Path], name: str | None = None, options: ImportOptions | None = None) -> ImportedRobot:
    """Return the robot of files of a format.

    *name*: name of the format; by default the content of the first file decides. Raises `InputError`: for a file of no
    known format, for several files where one is read, and as the format's reader.
    """
    chosen = _format_of(paths[0]) if name is None else name
    if chosen not in READ:
        raise UnknownName("format", chosen, READ)
    if len(paths) > READ[chosen].most_files:
        raise InputError(f"{paths[1]}: a second file; {READ[chosen].title} has one")
    wanted = options or ImportOptions()
    if wanted.cable_set is not None and chosen != "caspr":
        raise InputError(f"--cable-set = {wanted.cable_set!r}: only a CASPR model has sets of cables")
    if wanted.nozzle_below and chosen not in ("klipper", "reprapfirmware"):
        raise InputError(f"--nozzle-below: {READ[chosen].title} has no point where all lines meet above its nozzle")
    return READ[chosen].read(paths, wanted)


def _format_of(path: Path) -> str:
    """Return the name of the format that a file has by its content, else by its ending."""
    content = (
        read_bytes(path, xml_input.MAX_BYTES, "robot of another program").decode("utf-8", "replace").replace("\r", "\n")
    )
    for name, each in READ.items():
        if re.search(rf"(?:^|>)[ \t]*+(?:{each.begins})", content, re.MULTILINE | re.IGNORECASE):
            return name
    known = ", ".join(f"{each.title} ({', '.join(each.endings)})" for each in READ.values())
    ending = path.suffix.lower()
    if ending in READ["maslow"].endings:
        raise InputError(f"{path}: {maslow.described(maslow.yaml_entries(path))}; import reads {known}")
    for name, each in READ.items():
        if ending in each.endings:
            return name
    raise InputError(f"{path}: no format is known by its ending or content; --format names one of {known}")
