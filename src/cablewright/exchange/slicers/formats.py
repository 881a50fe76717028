"""Profiles as the files of PrusaSlicer, OrcaSlicer and Cura."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

from cablewright.exchange.slicers.profile import Profile, profile_of
from cablewright.exchange.translation_result import Notes
from cablewright.foundation.choices import SlicerName
from cablewright.foundation.errors import printable
from cablewright.foundation.progress import Progress, silent
from cablewright.printing.job import Bead
from cablewright.robot import Robot


@dataclass(frozen=True)
class Slicer:
    """A slicer: ``largest``, m, side of a bed that it supports, and the function that writes its files by name."""

    largest: float
    write: Callable[[Profile], dict[str, str]]


@dataclass(frozen=True, eq=False)
class SlicerFiles:
    """A slicer's profile: text of each file by name, and notes on lost and assumed values."""

    files: Mapping[str, str]
    lost: tuple[str, ...]
    assumed: tuple[str, ...]


def _prusa(profile: Profile) -> dict[str, str]:
    """Return a PrusaSlicer configuration, which `File, Import Config` and `--load` read."""
    mm = profile.mm
    width, height = mm(profile.width), mm(profile.height)
    printing, travel, faster = mm(profile.print_speed), mm(profile.travel_speed), mm(profile.acceleration)
    values: dict[str, Any] = {
        "printer_settings_id": printable(profile.name),
        "printer_technology": "FFF",
        "gcode_flavor": "reprapfirmware",
        "bed_shape": ",".join(profile.corners),
        "max_print_height": mm(profile.tall),
        "z_offset": mm(profile.bed),
        "nozzle_diameter": max(width, height),
        "max_layer_height": height,
        "min_layer_height": 0.5 * height,
        "layer_height": height,
        "first_layer_height": height,
        "use_relative_e_distances": 1,
        "layer_gcode": ";LAYER_CHANGE",
        "gcode_label_objects": 1,
        "gcode_comments": 0,
        "machine_limits_usage": "time_estimate_only",
        "default_acceleration": 0,
        "travel_speed": travel,
        "max_print_speed": printing,
        "start_gcode": profile.begin.replace("\n", "\\n"),
        "end_gcode": profile.end.replace("\n", "\\n"),
    }
    values |= {f"{kind}_speed": printing for kind in (
        "perimeter", "small_perimeter", "external_perimeter", "infill", "solid_infill", "top_solid_infill", "gap_fill",
        "support_material", "bridge", "first_layer",
    )}  # fmt: skip
    values |= {
        f"{kind}extrusion_width": width
        for kind in ("", "perimeter_", "external_perimeter_", "infill_", "solid_infill_", "top_infill_", "first_layer_")
    }
    values |= {f"machine_max_feedrate_{axis}": f"{travel:g},{travel:g}" for axis in "xyz"}
    values |= {f"machine_max_acceleration_{axis}": f"{faster:g},{faster:g}" for axis in "xyz"}
    return {"prusa.ini": "".join(f"{key} = {value}\n" for key, value in values.items())}


def _orca(profile: Profile) -> dict[str, str]:
    """Return presets of OrcaSlicer: a machine and a process for it."""
    mm, name = profile.mm, printable(profile.name)
    width, height = f"{mm(profile.width):g}", f"{mm(profile.height):g}"
    printing, travel, faster = (f"{mm(each):g}" for each in
                                (profile.print_speed, profile.travel_speed, profile.acceleration))  # fmt: skip
    machine: dict[str, Any] = {
        "type": "machine", "from": "User", "name": name, "inherits": "", "printer_settings_id": name,
        "printer_technology": "FFF", "gcode_flavor": "reprapfirmware", "printable_area": profile.corners,
        "printable_height": f"{mm(profile.tall):g}", "z_offset": f"{mm(profile.bed):g}", "nozzle_diameter": [width],
        "max_layer_height": [height], "min_layer_height": [f"{0.5 * float(height):g}"],
        "use_relative_e_distances": "1", "machine_start_gcode": profile.begin, "machine_end_gcode": profile.end,
        "before_layer_change_gcode": "", "layer_change_gcode": "", "emit_machine_limits_to_gcode": "0",
    }  # fmt: skip
    for axis in "xyz":
        machine[f"machine_max_speed_{axis}"] = [travel, travel]
        machine[f"machine_max_acceleration_{axis}"] = [faster, faster]
    process: dict[str, Any] = {
        "type": "process", "from": "User", "name": f"{name} strands", "inherits": "", "compatible_printers": [name],
        "layer_height": height, "initial_layer_print_height": height, "travel_speed": travel,
        "default_acceleration": "0", "gcode_label_objects": "1", "exclude_object": "1",
    }  # fmt: skip
    for kind in ("outer_wall", "inner_wall", "sparse_infill", "internal_solid_infill", "top_surface", "gap_infill",
                 "bridge", "initial_layer", "support"):  # fmt: skip
        process[f"{kind}_speed"] = printing
    for kind in ("", "outer_wall_", "inner_wall_", "sparse_infill_", "internal_solid_infill_", "top_surface_",
                 "initial_layer_", "support_"):  # fmt: skip
        process[f"{kind}line_width"] = width
    return {"orca-machine.json": _json(machine), "orca-process.json": _json(process)}


_CURA_WIDTHS: Final = (
    "line_width", "wall_line_width", "wall_line_width_0", "wall_line_width_x", "skin_line_width", "infill_line_width",
    "skirt_brim_line_width", "support_line_width",
)  # fmt: skip


def _cura(profile: Profile) -> dict[str, str]:
    """Return a definition of Cura, a rectangle around zero; it inherits what every printer there has."""
    mm, (wide, deep) = profile.mm, profile.rectangle
    values: dict[str, Any] = {
        "machine_name": printable(profile.name), "machine_width": mm(wide), "machine_depth": mm(deep),
        "machine_height": mm(profile.tall), "machine_center_is_zero": True, "machine_shape": "rectangular",
        "machine_gcode_flavor": "RepRap (RepRap)", "machine_heated_bed": False, "relative_extrusion": True,
        "machine_start_gcode": profile.begin, "machine_end_gcode": profile.end,
        "machine_nozzle_size": mm(max(profile.width, profile.height)), "layer_height": mm(profile.height),
        "layer_height_0": mm(profile.height), "speed_print": mm(profile.print_speed),
        "speed_travel": mm(profile.travel_speed), "machine_acceleration": mm(profile.acceleration),
    }  # fmt: skip
    values |= dict.fromkeys(_CURA_WIDTHS, mm(profile.width))
    for axis in "xyz":
        values[f"machine_max_feedrate_{axis}"] = mm(profile.travel_speed)
        values[f"machine_max_acceleration_{axis}"] = mm(profile.acceleration)
    definition: dict[str, Any] = {
        "version": 2,
        "name": printable(profile.name),
        "inherits": "fdmprinter",
        "metadata": {
            "visible": True, "author": "cablewright", "manufacturer": "own", "file_formats": "text/x-gcode",
            "has_materials": True, "machine_extruder_trains": {"0": "fdmextruder"},
        },
        "overrides": {key: {"default_value": value} for key, value in values.items()},
    }  # fmt: skip
    for key in ("line_width", "speed_travel"):  # which Cura computes unless a definition has their value
        definition["overrides"][key]["value"] = f"{values[key]:g}"
    return {"cura.def.json": _json(definition)}


SLICERS: Final[Mapping[SlicerName, Slicer]] = MappingProxyType({
    "prusa": Slicer(1.2, _prusa), "orca": Slicer(200.0, _orca), "cura": Slicer(100.0, _cura),
})  # fmt: skip
"""Slicers by name; PrusaSlicer has beds of up to 1200 mm."""


def slicer_files(name: SlicerName, robot: Robot, bead: Bead, *, progress: Progress = silent) -> SlicerFiles:
    """Return the files of a profile for strands of *bead*. Raises as `profile_of`."""
    lost, assumed = Notes(), Notes()
    profile = profile_of(robot, bead, SLICERS[name].largest, assumed, progress)
    lost.add("lines against the part as it grows, and the reach above the bed's outline: check counts them")
    if name == "cura":
        lost.add("the outline of the reach: Cura has a rectangle")
        x, y = profile.centre
        if x or y:
            assumed.add(f"origin: Cura has its zero in the middle of its bed: a job's origin is [{x:g}, {y:g}, 0] m")
        if profile.bed:
            lost.add(f"height of the bed, {profile.bed:g} m: give it as the z of a job's origin")
    files = SLICERS[name].write(profile)
    told = [*(f"lost: {each}" for each in lost.all), *(f"assumed: {each}" for each in assumed.all)]
    files = {
        file: "".join(f"# {printable(each)}\n" for each in told) + text if file.endswith(".ini") else text
        for file, text in files.items()
    }
    return SlicerFiles(MappingProxyType(files), lost.all, assumed.all)


def _json(table: dict[str, Any]) -> str:
    return json.dumps(table, indent=2) + "\n"
