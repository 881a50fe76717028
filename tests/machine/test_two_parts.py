"""A machine file in two parts: the owner's settings, and those of the simulation, which no estimator reads."""

from __future__ import annotations

import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.live.estimator_settings import OBSERVERS, started_settings
from cablewright.machine.files import load_machine, machine_names, machine_text
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.settings import MachineFile, SimulationSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load
from twins import SETTINGS, SIMULATION, START, TWIN, changed, machine

OWNER, MARK, _ = machine_text("merlet2023").partition("# Parameters of the simulation alone")

OTHER = """
[simulation]
substep = "5 ms"
quasi_static_period = "1 s"
tolerances = { anchor = "9 mm", sheave_radius = "1 mm", modulus = 0.1 }
winch = { radius_walk = "3 mm", walk_turns = 4.0, sideways_walk = "1 mm" }
line = { relaxation = "2 ms", vibration = "1 mm", vibration_damping = 0.1 }
climate = { temperature = 5.0, swing = 9.0, humidity = 0.1, humidity_swing = 0.0 }
room = { cell = "5 cm" }
wifi = { latency = "1 s", jitter = "1 s", loss = 0.5, gaps = [["1 s", "2 s"]] }
wire = { latency = "1 s" }
lidars = { north = { bias = "9 mm", dropout = 0.5, outliers = 0.1 } }
inertial = { acceleration_bias = 1.0, rate_bias = 1.0, outliers = 0.3 }
barrier = { intrusions = [["1 s", "2 s"]] }
faults = [{ source = "north" }]
[simulation.drum]
swing_damping = 9.0
yaw_stiffness = 2.0
yaw_damping = 0.1
yaw_wander = "9 deg"
yaw_wander_length = "2 m"
drag = 1.0
"""


def keys(schema: dict[str, Any], root: dict[str, Any], path: str = "") -> set[str]:
    """All keys of a JSON Schema, dotted."""
    found = set()
    options = [schema, *schema.get("anyOf", ())]
    tables = [root["$defs"][each["$ref"].split("/")[-1]] if "$ref" in each else each for each in options]
    for table in tables:
        for name, inner in table.get("properties", {}).items():
            found |= {f"{path}{name}"} | keys(inner, root, f"{path}{name}.")
        if isinstance(table.get("additionalProperties"), dict):
            found |= keys(table["additionalProperties"], root, f"{path}NAME.")
    return found


def test_machines_that_differ_in_the_simulation_are_one_to_an_estimator(tmp_path: Path) -> None:
    """Their settings are equal byte for byte, and so are those of each estimator."""
    (tmp_path / "other.toml").write_text(OWNER + OTHER)
    (tmp_path / "bare.toml").write_text(OWNER)
    assert load_twin(tmp_path / "other.toml").simulation != SIMULATION
    known = [load_machine(name) for name in ("merlet2023", tmp_path / "other.toml", tmp_path / "bare.toml")]
    known.append(load_twin(tmp_path / "other.toml").owner)
    assert len({each.model_dump_json() for each in known}) == 1
    assert {type(each) for each in known} == {MachineSettings}
    for observer in OBSERVERS.values():
        made = {pickle.dumps(observer.settings(load("merlet2023"), each, ())) for each in known}
        assert len(made) == 1


def test_no_key_is_in_both_parts_but_what_a_data_sheet_expects() -> None:
    owner, simulation = (each.model_json_schema() for each in (MachineSettings, SimulationSettings))
    both = keys(owner, owner) & keys(simulation, simulation)
    tables = {key for key in both if any(other.startswith(f"{key}.") for other in keys(owner, owner))}
    biases = ("lidars.NAME.bias", "inertial.acceleration_bias", "inertial.rate_bias")
    zeros = ("load_cells.bias", "load_cells.drift", "motor_torques.bias", "motor_torques.drift")
    assert both - tables == {*biases, *zeros}


def test_the_owner_needs_no_simulation_and_does_not_read_one(tmp_path: Path) -> None:
    for name, rest in (("bare", ""), ("broken", "[simulation]\nsubstep = 'soon'\nnothing = 3")):
        (tmp_path / f"{name}.toml").write_text(OWNER + rest)
        assert load_machine(tmp_path / f"{name}.toml") == SETTINGS
    with pytest.raises(InputError, match=r"broken\.toml: simulation: nothing: unknown key|simulation\.nothing = 3"):
        load_twin(tmp_path / "broken.toml")


OLD_KEYS = sorted(
    (path, key, table)
    for path, model in {
        "": MachineSettings,
        **{
            name: next(each for each in (field.annotation, *getattr(field.annotation, "__args__", ()))
                       if hasattr(each, "MOVED"))
            for name, field in MachineSettings.model_fields.items()
            if name in ("drum", "winch", "room", "inertial", "line_angles", "distance", "encoders", "climate_sensor",
                        "barrier")
        },
    }.items()
    for key, table in model.MOVED.items()
)  # fmt: skip


@pytest.mark.parametrize(("path", "key", "table"), OLD_KEYS)
def test_a_key_of_the_old_form_is_rejected_with_where_it_belongs(
    path: str, key: str, table: str, tmp_path: Path
) -> None:
    text = (
        re.sub(rf"^\[{path}\].*$", rf"\g<0>\n{key} = 1", OWNER, flags=re.MULTILINE) if path else f"{key} = 1\n{OWNER}"
    )
    (tmp_path / "old.toml").write_text(text)
    for reader in (load_machine, load_twin):
        with pytest.raises(InputError) as refusal:
            reader(tmp_path / "old.toml")
        place = f"{path}.{key}" if path else key
        assert f"old.toml: {place} = 1: belongs into {table} of the file now" in str(refusal.value)
    assert table.strip("[]").split(".")[0] == "simulation"
    assert any(each.endswith(f".{key}") for each in keys(SCHEMA, SCHEMA) if each.startswith("simulation."))


SCHEMA = MachineFile.model_json_schema()


def test_an_old_file_says_all_that_moved_at_its_top(tmp_path: Path) -> None:
    (tmp_path / "old.toml").write_text('schema = 1\nname = "x"\nsubstep = "2 ms"\n[tolerances]\n[line]\n[wifi]\n')
    with pytest.raises(
        InputError, match=r"substep = '2 ms': belongs into \[simulation\] of the file now; moved too: to"
    ):
        load_machine(tmp_path / "old.toml")


@pytest.mark.parametrize(
    ("removed", "says"),
    [
        ("[distance]", r"simulation\.distance: the machine has no such sensor: no \[distance\]"),
        ("[lidars.south]", r"simulation\.lidars\.south: the machine has no such lidar: no \[lidars.south\]"),
    ],
)
def test_flaws_of_a_sensor_that_is_not_there_are_rejected(removed: str, says: str, tmp_path: Path) -> None:
    text = re.sub(rf"^{re.escape(removed)}.*?\n\n", "", machine_text("merlet2023"), flags=re.MULTILINE | re.DOTALL)
    assert removed not in text
    (tmp_path / "own.toml").write_text(text)
    with pytest.raises(InputError, match=says):
        load_twin(tmp_path / "own.toml")


def test_a_unit_may_be_off_its_data_sheet() -> None:
    """The machine's errors follow the simulation; the estimator still believes the data sheet."""
    flaws = {name: flaw.model_copy(update={"bias": 0.0}) for name, flaw in SIMULATION.lidars.items()}
    better = changed(inertial={"rate_bias": 0.002}).with_simulation(lidars=flaws)
    better = better.with_simulation(inertial=SIMULATION.inertial.model_copy(update={"rate_bias": 0.0}))
    made, usual = machine(better), machine()
    assert made._sensors["north"].bias == 0.0 != usual._sensors["north"].bias
    assert (made._sensors["inertial"].bias[3:] == 0.0).all()
    np.testing.assert_array_equal(made._sensors["inertial"].bias[:3], usual._sensors["inertial"].bias[:3])
    assert started_settings(load("merlet2023"), made.settings).filter.height_bias_sigma == 2e-3


def test_winding_may_be_unlike_what_the_owner_expects() -> None:
    rough = changed(winch={"radius_walk": 5e-3})
    assert rough.owner == TWIN.owner
    first = [made.rig.winches.radii[:, :25] for made in (machine(rough), machine())]  # the first layer
    assert first[0].std() > 3.0 * first[1].std()
    unknown = changed(winch={"radius_deviation": 0.0})
    assert unknown.simulation == TWIN.simulation
    assert started_settings(load("merlet2023"), unknown.owner).filter.radius_noise > 0.0


@pytest.mark.parametrize("name", machine_names())
def test_the_library_has_both_parts(name: str) -> None:
    twin = load_twin(name)
    assert twin.owner == load_machine(name)
    assert twin.owner.winch.radius_deviation == twin.simulation.winch.radius_walk
    start = START if load(name).n == 3 else [0.1, 0.1, 0.6]
    assert SimulatedMachine(load(name), twin, start, seed=0).settings == twin.owner
