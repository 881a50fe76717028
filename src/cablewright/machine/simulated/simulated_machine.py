"""The simulated machine: a true robot moved by a plant, measured by sensors over imperfect links."""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Iterable, Iterator
from types import SimpleNamespace
from typing import Any, Final, Protocol, Self, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import PlantName
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.saved_state import Coded, Snapshot, load, save
from cablewright.foundation.signals import (
    RETRACTION,
    SOURCES,
    YAW,
    Barrier,
    Command,
    Condition,
    Notice,
    Reading,
    SensorFrame,
    Truth,
    WinchMode,
    per_line,
)
from cablewright.machine.interface import RESET, Abilities, check_command
from cablewright.machine.sensors import SENSORS
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.as_built import as_built
from cablewright.machine.simulated.as_built_parts import as_built_machine, mass_factors, places_along
from cablewright.machine.simulated.as_built_room import FoundRoom
from cablewright.machine.simulated.lidar import SimulatedLidar
from cablewright.machine.simulated.link import Channel, Gaps, decode_readings, encode_readings
from cablewright.machine.simulated.plant import DynamicPlant, Plant, QuasiStaticPlant
from cablewright.machine.simulated.sensor_context import Mounted
from cablewright.machine.simulated.sensors import SIMULATED
from cablewright.machine.simulated.settings import (
    FaultPlan,
    LidarFlaws,
    SimulationSettings,
    TwinSettings,
    check_faults,
)
from cablewright.machine.simulated.true_state import Rig, RigState, start_pose
from cablewright.machine.simulated.wireless_clock import DrumClock
from cablewright.robot import Robot

PLANTS: Final = get_args(PlantName)
_SHIFTS: Final = {(each.sensor.source, kind): shift for each in SIMULATED for kind, shift in each.faults.items()}


class _Sensor(Protocol):
    def read(self, state: RigState) -> Reading | None: ...


_LINK_TIMEOUT: Final = 0.5  # s without a message, after which the wireless link counts as silent


class SimulatedMachine:
    """A simulated `Machine`. `truth` and `rig` are for the evaluation of estimates, not for estimation or control."""

    SAVED = (
        "_start",
        "_steps",
        "_last_command_time",
        "rig",
        "_plant",
        "_sensors",
        "_wifi",
        "_wire",
        "_barrier_wire",
        Coded("_held", encode_readings, decode_readings),
    )

    def __init__(
        self,
        robot: Robot,
        settings: TwinSettings,
        start: ArrayLike,
        *,
        seed: int,
        plant: PlantName = "dynamic",
    ) -> None:
        """Build a machine as *robot* describes it within tolerances, by *seed*, at rest at *start* (n,), a pose.

        (3,) m of a body is a pose without rotation. A platform that retracts begins with the length of *robot*.

        Raises `InputError` for what cannot be simulated (a rate that does not fit, an unknown plant, a robot without
        the data of a winch), `AnswerError` where the drum has no equilibrium at *start*.
        """
        if plant not in PLANTS:
            raise UnknownName("plant", plant, PLANTS)
        check_faults(settings, tuple(line.name for line in robot.lines), robot.winch_names)
        self._start = np.nan_to_num(start_pose(robot, start))
        self._identity = _identity_of(robot, settings, seed, plant)
        tolerances = settings.simulation.tolerances
        true_robot, built = as_built(robot, tolerances, seed), as_built_machine(settings, seed)
        self.rig = Rig(true_robot, built, start, seed, places_along(tolerances, seed, robot.m))
        _, self._powder_factor = mass_factors(tolerances, seed)
        self._clock = DrumClock(settings.simulation, seed)
        self._twin = settings
        if plant == "quasi-static":
            self._twin, built = _for_quasi_static(settings), _for_quasi_static(built)
        self._plant: Plant = DynamicPlant(self.rig) if plant == "dynamic" else QuasiStaticPlant(self.rig)
        robot, winch, nozzle = self.rig.robot, settings.owner.winch, self.rig.masses.nozzle
        self._mounted = Mounted(robot, nozzle, winch, tolerances, self.period, seed)
        self._sensors = dict(self._mount(built.owner))
        self._wifi, self._wire, self._barrier_wire = (  # a light barrier has a wire of its own
            Channel(link, np.random.default_rng([seed, 4, k]), Gaps(link, seed, k))
            for k, link in enumerate((self.simulation.wifi, self.simulation.wire, self.simulation.wire))
        )
        self._channels = {
            name: self._wifi if source.clock == "drum" else self._wire for name, source in SOURCES.items()
        } | {Barrier.source: self._barrier_wire}
        self._wireless = any(self._channels[source] is self._wifi for source in self._sensors)
        self._faults = {source: [f for f in settings.simulation.faults if f.source == source] for source in SOURCES}
        self._held_readings: dict[FaultPlan, Reading] = {}
        self._abilities = self._able()
        self._outputs = bool(self._abilities.outputs)
        self._steps, self._last_command_time = 0, -np.inf
        self._rig_state = self.rig.observe(0.0)
        for sensor in self._sensors.values():
            if isinstance(sensor, SimulatedLidar):
                sensor.read(self._rig_state)

    @property
    def settings(self) -> MachineSettings:
        """The owner's settings; of a quasi-static machine with slower sensors."""
        return self._twin.owner

    @property
    def simulation(self) -> SimulationSettings:
        """Settings of the simulation alone."""
        return self._twin.simulation

    @property
    def period(self) -> float:
        """Time of one step, s."""
        return self._plant.period

    @property
    def abilities(self) -> Abilities:
        """Abilities of the simulation, which takes no time and knows the truth."""
        return self._abilities

    def open(self) -> None:
        """Connect to the machine; see `Machine.open`. A simulation needs no connection."""

    def stop(self) -> None:
        """Stop and hold all winches; see `Machine.stop`. Its winches rest between two steps."""

    def close(self) -> None:
        """Disconnect from the machine; see `Machine.close`."""

    @property
    def time(self) -> float:
        """The machine's clock, s."""
        return self._steps * self.period

    @property
    def truth(self) -> Truth:
        """The true state at the end of the last step."""
        return self._rig_state.truth

    @property
    def robot(self) -> Robot:
        """The robot as built, with the container as full as at the start."""
        return self.rig.robot

    def refill(self, powder: float) -> None:
        """Set the *powder* in the container, kg, as it is weighed. Raises `InputError` for more than its capacity."""
        capacity, what = self.settings.carrier.capacity, "drum" if self.settings.body is None else "hopper"
        if not 0.0 <= powder <= capacity:
            raise InputError(f"powder = {powder:g} kg: the {what} takes 0 to {capacity:g} kg")
        self.rig.fill(powder * self._powder_factor)
        self._rig_state = self.rig.observe(self.time)

    def step(self, command: Command) -> SensorFrame:
        """Send *command*, wait for the step, and return the readings that arrived; see `Machine.step`."""
        speeds, rig, wifi = self._checked(command), self.rig, self._wifi
        if self._outputs:
            rig.retraction.command(command.outputs.get(RETRACTION, 0.0))
            rig.yaw.command(command.outputs.get(YAW, 0.0))
            rig.brake(command.modes, command.outputs.get(RESET, 0.0) > 0.0)
        begin, period = self.time, self._plant.period
        notices = rig.advance_slowly(begin, period, command.valve)
        notices += self._plant.advance(speeds)
        rig.advance_unmodelled(begin, period)
        notices += rig.take_notices()
        self._steps += 1
        now = self._steps * period
        self._rig_state = state = rig.observe(now)
        for source, sensor in self._sensors.items():
            reading = sensor.read(state)
            if reading is not None and self._faults[source]:
                reading = self._apply_faults(source, reading)
            if reading is not None:
                channel = self._channels[source]
                channel.send(now, self._clock.stamped(reading) if channel is wifi else reading)
        readings = (*self._barrier_wire.arrived(now), *self._wire.arrived(now), *wifi.arrived(now))
        if now - wifi.last_arrival_time > _LINK_TIMEOUT and self._wireless:
            notices.append(Notice(Condition.SILENT, "wifi"))
        return SensorFrame(now, readings, tuple(notices))

    def snapshot(self) -> Snapshot:
        """The complete state, from which `resumed` continues."""
        snapshot = save(self)
        snapshot.values["machine"] = self._identity
        return snapshot

    @classmethod
    def resumed(
        cls,
        robot: Robot,
        settings: TwinSettings,
        snapshot: Snapshot,
        *,
        seed: int,
        plant: PlantName = "dynamic",
    ) -> Self:
        """Return a machine that continues, to the bit, like the one from which *snapshot* was taken.

        Raises `InputError` for an invalid snapshot, or one of another robot, machine, seed or plant.
        """
        if snapshot.values.get("machine") != _identity_of(robot, settings, seed, plant):
            raise InputError("the snapshot is of another machine: robot, settings, seed or plant differ")
        began = SimpleNamespace(SAVED=("start",), start=np.zeros(robot.n))
        load(began, snapshot)
        machine = cls(robot, settings, began.start, seed=seed, plant=plant)
        load(machine, snapshot)
        return machine

    def after_load(self) -> None:
        """Compute the true state of the loaded rig."""
        self._rig_state = self.rig.observe(self.time)

    @property
    def _held(self) -> list[tuple[float, Reading]]:
        """Readings at which faults hold a sensor, with the faults' numbers."""
        plans = self.simulation.faults
        return [(plans.index(plan), reading) for plan, reading in self._held_readings.items()]

    @_held.setter
    def _held(self, held: Iterable[tuple[float, Reading]]) -> None:
        plans = self.simulation.faults
        if not all(number in range(len(plans)) for number, _ in held):
            raise InputError("snapshot: held: a fault that is not planned")
        self._held_readings = {plans[int(number)]: reading for number, reading in held}

    def _checked(self, command: Command) -> Array:
        """Return the speeds of a valid command, else raise `InputError`."""
        check_command(self._abilities, command, self._last_command_time)
        self._last_command_time = command.time
        return np.array(command.winch_speeds, dtype=np.float64)

    def _able(self) -> Abilities:
        brakes = self.rig.brakes is not None
        outputs = {
            RETRACTION: self.rig.retraction.has_drive,
            YAW: self.rig.yaw.has_drive,
            RESET: brakes,
        }
        return Abilities(
            self.rig.robot.winches,
            frozenset(self._sensors),
            frozenset({WinchMode.OFF, WinchMode.HOLD, WinchMode.VELOCITY}),
            frozenset(name for name, is_there in outputs.items() if is_there),
            brakes=brakes,
            real_time=False,
            truth=lambda: self.truth,
            snapshot=self.snapshot,
            refill=self.refill,
        )

    def _mount(self, built: MachineSettings) -> Iterator[tuple[str, _Sensor]]:
        """Yield all sensors as *built* by source, each with its own generator: leaving one out changes no other."""
        simulation, machine = self.simulation, self._mounted
        ends = [end for wall in built.room.walls for end in (wall.start, wall.end)]
        scene = machine.robot.scene
        corners = np.array([*ends, scene.frame_min[:2], scene.frame_max[:2]])
        low, high = corners.min(axis=0), corners.max(axis=0)
        room = FoundRoom(built.room, simulation, low, high, built.carrier.radius, machine.seed)
        for source, lidar in built.lidars.items():
            flaws = simulation.lidars.get(source, LidarFlaws())
            yield source, SimulatedLidar(source, lidar, flaws, room, machine.period, machine.random(source))
        for each in SIMULATED:
            sheet = built.sensor(each.sensor)
            if sheet is not None:
                yield each.sensor.source, each.reader(each.sensor, sheet, simulation.flaws(each), machine)

    def _apply_faults(self, source: str, reading: Reading) -> Reading | None:
        """Return *reading* after the faults that are planned for its time; None: lost."""
        for fault in self._faults[source]:
            if not fault.begin <= reading.time < fault.end:
                self._held_readings[fault] = reading
                continue
            if (source, fault.kind) in _SHIFTS:
                reading = self._apply_shift(fault, reading)
            elif fault.line is not None:
                reading = self._apply_line_fault(fault, fault.line, reading)
            elif fault.kind == "silent":
                return None
            else:
                reading = self._held_readings.setdefault(fault, reading).stamped(reading.stamp)
        return reading

    def _apply_shift(self, fault: FaultPlan, reading: Reading) -> Reading:
        """Return *reading* with the fault's size added to the numbers of its lines."""
        sizes = [fault.size if fault.line in (None, name) else 0.0 for name in self._names_of(reading)]
        values = _of_lines(reading)
        return _with_lines(reading, values + _SHIFTS[fault.source, fault.kind](np.array(sizes), self._mounted))

    def _names_of(self, reading: Reading) -> tuple[str, ...]:
        """Names of the lines, or winches, of which a reading has the numbers."""
        (mark,) = per_line(type(reading)).values()
        return self.rig.robot.winch_names if mark.winch else tuple(line.name for line in self.rig.robot.lines)

    def _apply_line_fault(self, fault: FaultPlan, line: str, reading: Reading) -> Reading:
        """Return *reading* with one line's number lost or stuck."""
        index = self._names_of(reading).index(line)
        values, held = _of_lines(reading).copy(), self._held_readings.setdefault(fault, reading)
        values[index] = np.nan if fault.kind == "silent" else _of_lines(held)[index]
        return _with_lines(reading, values)


def _of_lines(reading: Reading) -> NDArray[Any]:
    """The numbers of a reading that is of lines alone, (m,)."""
    (name,) = per_line(type(reading))
    return np.asarray(getattr(reading, name))


def _with_lines(reading: Reading, values: NDArray[Any]) -> Reading:
    """The same reading with other numbers, which keep their type."""
    (name,) = per_line(type(reading))
    changed: dict[str, Any] = {name: values.astype(getattr(reading, name).dtype)}
    changed[name].flags.writeable = False
    return dataclasses.replace(reading, **changed)


def _identity_of(robot: Robot, settings: TwinSettings, seed: int, plant: str) -> str:
    """Hash by which a snapshot is recognised as this machine's."""
    text = "\n".join((robot.model_dump_json(), settings.model_dump_json(), str(seed), plant))
    return hashlib.sha256(text.encode()).hexdigest()


def _for_quasi_static(settings: TwinSettings) -> TwinSettings:
    """Settings for quasi-static periods: faster sensors are read as each ends, as means; no link delays."""
    max_rate = 1.0 / settings.simulation.quasi_static_period
    slowed: dict[str, Any] = {}
    for each in SENSORS:
        sensor = settings.owner.sensor(each)
        if sensor is not None and sensor.rate > max_rate:
            share = math.sqrt(max_rate / sensor.rate)
            noise = {key: share * getattr(sensor, key) for key in each.noise}
            slowed[each.table] = sensor.model_copy(update={"rate": max_rate, **noise})
    links = {
        name: getattr(settings.simulation, name).model_copy(update={"latency": 0.0, "jitter": 0.0})
        for name in ("wifi", "wire")
    }
    if settings.owner.clock is not None:
        slowed["clock"] = settings.owner.clock.model_copy(update={"latency": 0.0, "age": 0.0})
    return settings.with_owner(**slowed).with_simulation(**links)
