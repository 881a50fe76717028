"""A machine restored from a snapshot goes on, to the bit, as the one that was never interrupted; any file is safe."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.saved_state import Snapshot, read_snapshots, write_snapshots
from cablewright.foundation.signals import Barrier, Command
from cablewright.kernels.plant import winding
from cablewright.machine.log.messages import encode
from cablewright.machine.simulated.settings import FaultPlan
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load
from twins import TWIN, changed, machine, run

SPEEDS = np.array([0.3, -0.3, 0.1, 0.0])


def troubled(period: float) -> Any:
    """Faults, a gap and an intrusion under way all along, at a step of *period*, s."""
    plans = tuple(
        FaultPlan(source=source, kind=kind, begin=begin * period, end=end * period, line=line)
        for source, kind, begin, end, line in (
            ("north", "stuck", 90.0, 400.0, None),
            ("line_angles", "stuck", 20.0, 300.0, "north-west"),
            ("inertial", "silent", 100.0, 200.0, None),
            ("barrier", "stuck", 30.0, 90.0, None),
            ("vertical", "stuck", 1e6, 2e6, None),
        )
    )
    gaps = ((30.0 * period, 80.0 * period), (150.0 * period, 260.0 * period))
    jitters = {"jitter": 0.5 * period, "loss": 0.05}
    made = changed(wifi={**jitters, "gaps": gaps}, wire=jitters, barrier={"intrusions": ((1.0, 2.0),)})
    return made.with_simulation(faults=plans)


def outputs(twin: SimulatedMachine, steps: int) -> list[Any]:
    """All output of *steps* steps, as bytes, and the truth."""
    found = []
    for _ in range(steps):
        command = Command(twin.time, SPEEDS * np.cos(0.4 * twin.time), 1.0)
        frame = twin.step(command)
        readings = [encode(reading, "abcd", 1024) for reading in frame.readings]
        found.append((frame.time, readings, frame.notices, encode(twin.truth, "abcd", 1024)))
    return found


def again(snapshot: Snapshot, settings: Any = TWIN, seed: int = 1, plant: Any = "dynamic") -> SimulatedMachine:
    return SimulatedMachine.resumed(load("merlet2023"), settings, snapshot, seed=seed, plant=plant)


@pytest.mark.parametrize(("plant", "period"), [("dynamic", 0.01), ("quasi-static", 0.2)])
def test_a_restored_machine_goes_on_to_the_bit(plant: str, period: float, tmp_path: Path) -> None:
    settings, random = troubled(period), np.random.default_rng(7)
    whole = machine(settings, plant=plant)
    broken = machine(settings, plant=plant)
    total = 330
    stops = np.diff([0, *np.sort(random.choice(total, 6, replace=False)), total])
    for round_, steps in enumerate(stops):
        assert outputs(whole, steps) == outputs(broken, steps)
        if round_ == 3:
            whole.refill(30.0)
            broken.refill(30.0)
        write_snapshots(tmp_path / "state", {"machine": broken.snapshot()})
        outputs(broken, 5)  # what a snapshot was taken of may go on: it is a copy
        broken = again(read_snapshots(tmp_path / "state")["machine"], settings, plant=plant)
        assert encode(broken.truth, "abcd", 1024) == encode(whole.truth, "abcd", 1024)
    assert np.array_equal(whole.rig.ground.heights, broken.rig.ground.heights)
    assert whole.rig.ground.mass > 0.0
    mine, others = whole.snapshot(), broken.snapshot()
    assert mine.values == others.values
    assert mine.arrays.keys() == others.arrays.keys()
    for name, values in mine.arrays.items():
        np.testing.assert_array_equal(values, others.arrays[name], err_msg=name)


def test_a_file_holds_what_belongs_together(tmp_path: Path) -> None:
    control = Snapshot({"layer": 3, "why": "ü", "never": -np.inf}, {"gains": np.arange(6.0).reshape(2, 3)})
    counts = Snapshot({}, {"counts": np.array([2**62, -1]), "none": np.zeros((0, 7))})
    write_snapshots(tmp_path / "state", {"control": control, "counts": counts})
    found = read_snapshots(tmp_path / "state")
    assert found["control"].values == control.values
    for name, snapshot in (("control", control), ("counts", counts)):
        for key, values in snapshot.arrays.items():
            kept = found[name].arrays[key]
            assert (kept.dtype, kept.shape) == (values.dtype, values.shape)
            np.testing.assert_array_equal(kept, values)
    assert [path.name for path in tmp_path.iterdir()] == ["state"]


def test_a_snapshot_of_another_machine_is_rejected() -> None:
    snapshot = machine(plant="quasi-static").snapshot()
    again(snapshot, plant="quasi-static")
    for given in ({"seed": 2}, {"plant": "dynamic"}, {"settings": changed(drum={"powder": 1.0})}):
        with pytest.raises(InputError, match="another machine"):
            again(snapshot, **{"plant": "quasi-static", **given})


def _without(snapshot: Snapshot, **changes: Any) -> Snapshot:
    values = {**snapshot.values, **{k: v for k, v in changes.items() if not isinstance(v, np.ndarray)}}
    return Snapshot(values, {**snapshot.arrays, **{k: v for k, v in changes.items() if isinstance(v, np.ndarray)}})


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("steps", -1, "steps: a whole number"),
        ("steps", 10**400, "steps: a whole number"),
        ("last_command_time", "now", "last_command_time: a number"),
        ("rig.random", [1, 2, 3], "the state of a random generator"),
        ("rig.random", [2**128, 1, 0, 0], "the state of a random generator"),
        ("rig.motion", np.full(12, np.nan), "not finite"),
        ("rig.motion", np.zeros(11), "float64 (12,) is expected"),
        ("rig.winch_flags", np.zeros(4), "int64 (4,) is expected"),
        ("rig.winches.state", np.full((4, winding.WINCH), 1e6), "a winch drum is wound"),
        ("rig.ground.field.heights", [0], "where a block begins"),
        ("rig.ground.field.heights", [0, 501], "does not fit into (250, 500)"),
        ("rig.ground.field.heights", [-1, 0], "where a block begins"),
        ("rig.ground.field.heights", np.zeros(3), "does not fit into (250, 500)"),
        ("rig.ground.field.heights", np.full((2, 2), np.inf), "not finite"),
        ("sensors.north.poses", np.zeros((5, 7)), "float64 (6, 7) is expected"),
        ("sensors.north.count", 6, "must be at most 5"),
        ("wire.sent", [[1.0, "/truth", "{}"]], "a message of /truth"),
        ("wire.sent", [[1.0, "/climate", "{"]], "not valid JSON"),
        ("wire.sent", [[1.0, "/frame", '{"time": 1, "notices": []}']], "no topic of a reading"),
        ("wire.sent", 3, "a list of number, topic and message"),
        ("held", [[1.0, "/barrier", '{"time": 1, "broken": true}']], "not planned"),
    ],
)
def test_what_does_not_fit_is_named(name: str, value: Any, says: str) -> None:
    snapshot = machine(plant="quasi-static").snapshot()
    with pytest.raises(InputError) as refused:
        again(_without(snapshot, **{name: value}), plant="quasi-static")
    assert says in str(refused.value)
    missing = Snapshot(
        {key: each for key, each in snapshot.values.items() if key != name},
        {key: each for key, each in snapshot.arrays.items() if key != name},
    )
    with pytest.raises(InputError, match="missing"):
        again(missing, plant="quasi-static")


def test_a_damaged_file_is_rejected_whatever_the_damage(tmp_path: Path) -> None:
    path, random = tmp_path / "state", np.random.default_rng(3)
    write_snapshots(path, {"a": Snapshot({"x": 1}, {"y": np.arange(20.0)}), "b": Snapshot({}, {})})
    whole = path.read_bytes()
    for _ in range(300):
        damaged = bytearray(whole)
        damaged[random.integers(len(whole))] ^= 1 << int(random.integers(8))
        path.write_bytes(damaged[: random.integers(len(whole))] if random.random() < 0.3 else damaged)
        with pytest.raises(InputError) as refused:
            read_snapshots(path)
        assert "\n" not in str(refused.value)
    with pytest.raises(InputError, match="no such file"):
        read_snapshots(tmp_path / "none")


@pytest.mark.parametrize(
    ("head", "says"),
    [
        (b"[", "Invalid JSON"),
        (b"[" * 100_000, "Invalid JSON"),
        (b'{"schema":2,"parts":{}}', "schema: must be 1"),
        (b'{"schema":1,"parts":{"a":[]}}', "must be an object"),
        (b'{"schema":1,"parts":{"a":{"values":{},"arrays":{"y":["O8",[1]]}}}}', "must be 'b1', 'f8' or 'i8'"),
        (b'{"schema":1,"parts":{"a":{"values":{},"arrays":{"y":["f8",[-1]]}}}}', "must be greater than or equal to 0"),
        (b'{"schema":1,"parts":{"a":{"values":{},"arrays":{"y":["f8",[1000000000000]]}}}}', "longer than the file"),
        (
            b'{"schema":1,"parts":{"a":{"values":{},"arrays":{"y":["f8",[0,268435456,268435456,8]]}}}}',
            "longer than the",
        ),
        (b'{"schema":1,"parts":{}}12345678', "Invalid JSON"),
    ],
)
def test_a_head_that_lies_is_rejected(head: bytes, says: str, tmp_path: Path) -> None:
    path = tmp_path / "state"
    path.write_bytes(struct.pack("<8sII", b"CWSNAP\x00\x01", len(head), zlib.crc32(head)) + head)
    with pytest.raises(InputError, match=says):
        read_snapshots(path)


def test_what_cannot_be_written_leaves_the_last_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "state"
    write_snapshots(path, {"a": Snapshot({"x": 1}, {})})

    def full(_file: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(EnvironmentFault, match="state: cannot be written: No space left on device"):
        write_snapshots(path, {"a": Snapshot({"x": 2}, {})})
    assert read_snapshots(path)["a"].values == {"x": 1}
    assert [each.name for each in tmp_path.iterdir()] == ["state"]


def test_a_light_barrier_reports_people_since_the_last_reading() -> None:
    twin = machine(changed(barrier={"rate": 5.0, "intrusions": ((0.41, 0.42), (0.9, 1.3))}))
    found = [(round(each.time, 6), each.broken) for each in run(twin, 201) if isinstance(each, Barrier)]
    assert [time for time, _ in found] == [0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0]
    assert [time for time, broken in found if broken] == [0.6, 1.0, 1.2, 1.4]


def test_a_light_barrier_changes_nothing_else() -> None:
    jitters = changed(wire={"jitter": 0.02, "loss": 0.1})
    bare = jitters.with_owner(barrier=None)
    both = [[encode(r, "abcd", 1024) for r in run(machine(given), 150)] for given in (jitters, bare)]
    assert [each for each in both[0] if each[0] != "/barrier"] == both[1]
    assert len(both[0]) > len(both[1])
