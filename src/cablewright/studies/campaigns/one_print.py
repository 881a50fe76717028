"""One print of a campaign: on the machine that a seed builds, with all tolerances or with one set to zero."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from cablewright.foundation.errors import InputError
from cablewright.live.prints.loop import run
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import attendant_of
from cablewright.machine.simulated.settings import Tolerances, TwinSettings
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.running.run_folders import file_hash
from cablewright.studies.campaigns.true_errors import TrueErrors

REMEDIES: Final[Mapping[str, str]] = {
    "anchor": "survey the exit points",
    "sheave_radius": "turn the sheaves to size, or measure them",
    "modulus": "measure the modulus of each cable",
    "wall": "survey the walls",
    "mount_place": "measure where sensors are mounted",
    "mount_turn": "measure how sensors are turned",
    "clock_offset": "set the platform's clock",
    "clock_drift": "discipline the platform's clock",
    "line_angle_bias": "calibrate the zeros of the lines' accelerometers",
    "tension_gain": "calibrate the scales of load cells and torques",
    "tension_drift": "load cells whose zeros drift less",
    "mass": "weigh the platform and what it carries",
    "home_length": "home the lines better",
    "drum_radius": "measure the drums",
}
"""What to do, or to buy, to meet each tolerance exactly."""


@dataclass(frozen=True)
class CampaignPrint:
    """Common data of all prints of a campaign. ``gcode_hash``: hash of its G-code file; empty: none."""

    robot: Robot
    job: Job
    machine: TwinSettings
    options: PrintOptions
    gcode_hash: str = ""

    @property
    def tolerances(self) -> dict[str, float]:
        """The tolerances of the machine that are not 0, by name."""
        own = self.machine.simulation.tolerances
        return {name: value for name in Tolerances.model_fields if (value := float(getattr(own, name))) > 0.0}

    def exact_in(self, tolerance: str) -> TwinSettings:
        """Return the machine with one tolerance set to zero; an empty name: with all tolerances."""
        if not tolerance:
            return self.machine
        own = self.machine.simulation.tolerances
        return self.machine.with_simulation(tolerances=own.model_copy(update={tolerance: 0.0}))


def printed(shared: CampaignPrint, item: tuple[int, str]) -> dict[str, Any]:
    """Print on the machine that a seed builds, and return its result: status, reason and errors, m."""
    seed, exact = item
    _require_file(shared)
    twin = twin_of(shared.robot, shared.job, shared.exact_in(exact), replace(shared.options, seed=seed))
    machine, printer = begin_print(twin, plan_print(twin))
    errors = TrueErrors(twin, machine)
    run(printer, attendant_of(machine, printer, twin.choices), errors)
    found = errors.path.result()
    return {
        "finished": printer.finished,
        "status": "finished" if printer.finished else printer.supervisor.state.value,
        "reason": printer.supervisor.reason,
        "max_error": found.error.size,
        "rms": errors.whole.result().position_rms,
        "distance": errors.distance,
        "duration": machine.time,
    }


def _require_file(shared: CampaignPrint) -> None:
    """Raise `InputError` unless the job's file here is that of the client: workers read it by its path."""
    file = shared.job.gcode
    if file is None:
        return
    if not file.exists() or file_hash(file) != shared.gcode_hash:
        raise InputError(
            f"{file}: the worker has no such file, or another; jobs of G-code need the same on all workers"
        )
