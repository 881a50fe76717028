"""`tags` and `camera`: printable pages of tags, and the lens of a camera from pictures of them."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import AsJson
from cablewright.apps.cli.output import answer, progress
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import write_whole


class Paper(StrEnum):
    """Paper sizes on which tags are printed."""

    A4 = "A4"
    A3 = "A3"
    A2 = "A2"
    A1 = "A1"


@command("tags examples/tags.toml --out runs/tags.pdf", "calibration.sightings.layout:PrintedTags")
def tags_command(
    *,
    layout: Annotated[
        Path | None,
        typer.Argument(metavar="TAGS.toml", help="Layout of the tags; by default the flat sheet for `camera`."),
    ] = None,
    out: Annotated[
        Path, typer.Option("--out", metavar="FILE", help="File to write: .pdf, or .svg, one for each page.")
    ],
    paper: Annotated[Paper, typer.Option("--paper", help="Size of the paper.")] = Paper.A4,
    as_json: AsJson = False,
) -> int:
    """Each page has a ruler, since printers scale: measure it, and give its error as print_sigma in the layout.

    Needs the extra camera.
    """
    from cablewright.apps.tag_sheet import pages_of, pdf_of, svg_of
    from cablewright.calibration.sightings.intrinsics import sheet
    from cablewright.calibration.sightings.layout import PrintedTags, load_layout

    if out.suffix.lower() not in (".pdf", ".svg"):
        raise InputError(f"--out = {str(out)!r}: must end with .pdf or .svg")
    tags = sheet() if layout is None else load_layout(layout)
    pages = pages_of(tags, paper.value)
    if out.suffix.lower() == ".pdf":
        files = {out: pdf_of(pages)}
    else:
        names = [out] if len(pages) == 1 else [out.with_stem(f"{out.stem}-{at}") for at in range(1, len(pages) + 1)]
        files = {name: svg_of(page).encode() for name, page in zip(names, pages, strict=True)}
    for file, content in files.items():
        write_whole(file, content, parents=True)
    return answer(PrintedTags(tags, len(pages), paper.value, tuple(map(str, files))), as_json)


@command("camera examples/phone.yml --out runs/phone.toml", "calibration.sightings.intrinsics:CameraFit")
def camera_command(
    *,
    pictures: Annotated[
        list[Path],
        typer.Argument(metavar="PICTURES", help="Pictures of the sheet, files or folders; or a file of OpenCV."),
    ],
    tags: Annotated[
        Path | None,
        typer.Option("--tags", metavar="TAGS.toml", help="Layout of the sheet; by default that of `tags`."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.toml", help="Camera file to write, with the lens found.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Take 10 to 20 pictures that the sheet fills, turned by 30 to 50 degrees, with focus and zoom fixed.

    A file of OpenCV's calibration, YAML or XML, is read instead, with assumed standard deviations. Needs the extra
    camera.
    """
    from cablewright.calibration.sightings.camera import camera_text

    with progress() as show:
        found = cw.camera(pictures, tags, progress=show)
    out = None if found.refusal else out
    if out is not None:
        comments = (
            f"from {found.pictures} pictures" if found.pictures else f"from {pictures[0].name}, sigmas assumed",
        )
        write_whole(out, camera_text(found.camera, comments).encode(), parents=True)
    return answer(found, as_json, out=out)
