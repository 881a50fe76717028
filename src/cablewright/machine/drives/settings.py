"""Settings of the table ``[drives]`` of a machine file: bus, nodes, and supervision by the drives themselves."""

from __future__ import annotations

from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from cablewright.foundation.units import Duration, Force, Length, Positive, Speed, Torque
from cablewright.foundation.validation import Description, refusal
from cablewright.machine.quantities import Factor

MAX_NODES: Final = 32
_MARGIN: Final = 0.2  # s
_GENTLE: Final = 1.0  # m/s^2
ACKNOWLEDGED: Final = "tested on virtual drives only"
"""What whoever uses a real bus has to write into the machine file."""

FOLLOWING_ERROR: Final = 0.02
"""How far a winch may be from where it was commanded if no file says, m of cable."""

LOOPBACK: Final = "loopback"
"""The interface of virtual drives."""

_Node = Annotated[int, Field(strict=True, ge=1, le=127)]
_Bit = Annotated[int, Field(strict=True, ge=0, le=31)]
_Brief = Annotated[Duration, Field(ge=1e-3, le=10.0)]
_Text = Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[A-Za-z0-9_.:/\\-]+$")]


class NodeSettings(Description):
    """The drive of one line. ``direction``: 1 where its motor pays out with a positive speed, else -1."""

    id: _Node
    direction: Literal[-1, 1]


class InputBits(Description):
    """Bits of the digital inputs, object 0x60FD, that every drive reads; None: not wired. A set bit is the safe state.

    ``chain``: the emergency-stop chain is closed. ``torque_on``: safe torque off is not active. ``enabling``: the
    enabling switch is pressed. ``brake``: the brake is closed. ``barrier``: the light barrier is clear.
    """

    chain: _Bit | None = None
    torque_on: _Bit | None = None
    enabling: _Bit | None = None
    brake: _Bit | None = None
    barrier: _Bit | None = None


class ValveSettings(Description):
    """The nozzle's valve: a digital output, object 0x60FE, of the drive of ``line``, which opens it with its ``bit``.

    ``closes_alone``: whether that drive clears the output by itself in a fault, and when it loses this computer. No
    standard says so: it is in the drive's manual.
    """

    line: _Text
    bit: _Bit
    closes_alone: Annotated[bool, Field(strict=True)]


class WinchDriveSettings(Description):
    """Drives of profile CiA 402 on CANopen or EtherCAT, one for each line, each of which closes its own brake.

    ``interface``, ``channel``, ``bitrate``: settings of the bus as python-can takes them; the interface ``loopback`` is
    that of virtual drives, its channel a UDP port of this computer. Of EtherCAT the interface is that of the network,
    and the channel, if any, the one at which virtual drives answer; a node's id is its place in the ring.
    ``acknowledged``: a real bus is opened for motion only with `ACKNOWLEDGED`. ``host``: node of this computer.
    ``rated_torque``: rated torque of a motor, as each drive must have it (0x6076). ``speed_unit``: value of 0x60FF that
    means one turn of the motor per second; None: the value is in counts per second. ``heartbeat_timeout``,
    ``command_timeout``: time without a message of this computer after which a drive stops by itself, s. A drive also
    stops when its following error exceeds ``following_error`` (m of cable) for ``following_time`` (s).
    ``deceleration``: deceleration of the cable, at every stop by a drive. ``brake_time``: time until a brake has opened
    or closed, s. ``answer_timeout``: time after which a drive that does not answer counts as silent, s. ``tension``:
    highest tension of a line that is taken up, N; ``tension_speed``: highest speed of its cable in torque mode.
    ``tension_error``: allowed error of all tensions together, as a share of the platform's weight. ``jog_run_out``:
    distance that a jog may continue after the last order, m. ``jog_tension``: tension up to which a winch reels in by
    hand, N; None: ``tension``.
    """

    interface: _Text
    channel: _Text = ""
    acknowledged: Literal["tested on virtual drives only"] | None = None
    bitrate: Annotated[int, Field(strict=True, ge=10_000, le=1_000_000)] = 1_000_000
    host: _Node = 127
    nodes: dict[str, NodeSettings] = Field(min_length=1, max_length=MAX_NODES)
    rated_torque: Positive[Torque]
    speed_unit: Factor | None = None
    heartbeat_timeout: _Brief = 0.2
    command_timeout: _Brief = 0.1
    answer_timeout: _Brief = 0.05
    following_error: Annotated[Length, Field(ge=1e-4, le=0.1)] = FOLLOWING_ERROR
    following_time: _Brief = 0.05
    deceleration: Annotated[float, Field(ge=0.01, le=10.0)] = 1.0
    brake_time: Annotated[Duration, Field(ge=0.02, le=10.0)] = 0.2
    tension: Positive[Force]
    jog_tension: Positive[Force] | None = None
    jog_run_out: Annotated[Length, Field(ge=0.005, le=0.5)] = 0.1
    tension_error: Annotated[float, Field(ge=0.01, le=0.5)] = 0.1
    tension_speed: Annotated[Speed, Field(gt=0.0, le=0.25)] = 0.02
    inputs: InputBits = InputBits()
    valve: ValveSettings | None = None

    def stop_time(self, speed: float) -> float:
        """Time, s, in which a drive stops from a *speed* of its cable, m/s, closes its brake, and reports it."""
        return speed / self.deceleration + self.brake_time + self.answer_timeout + _MARGIN

    @property
    def valve_notes(self) -> tuple[str, ...]:
        """Warning to the operator at the start of a print about valve properties that the file does not state."""
        if self.valve is None:
            return ("drives.valve: is not named: the platform moves, but no valve opens: nothing is laid",)
        if self.valve.closes_alone:
            return ()
        why = "its drive leaves it open in a fault, and when this computer is lost"
        return (f"drives.valve.closes_alone = false: {why}: the emergency-stop chain has to shut it",)

    @property
    def jog_deceleration(self) -> float:
        """Deceleration of a jog whose key is released, m/s^2: that of a stop, unless the load would swing."""
        return min(self.deceleration, _GENTLE)

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        if self.valve is not None and self.valve.line not in self.nodes:
            raise refusal("line", "has no drive in drives.nodes", ("valve",))
        ids = [node.id for node in self.nodes.values()]
        for name, node in self.nodes.items():
            if node.id == self.host:
                raise refusal("id", f"{node.id} is this computer's (drives.host)", ("nodes", name))
            if ids.count(node.id) > 1:
                raise refusal(
                    "id", f"two lines have the node {node.id}; each needs a drive of its own", ("nodes", name)
                )
        if self.interface == LOOPBACK and not (self.channel.isdigit() and 1024 <= int(self.channel) <= 65535):
            raise refusal("channel", "must be a UDP port from 1024 to 65535, as text, with interface = loopback")
        return self
