"""A virtual servo drive by CiA 301 and CiA 402: states, ramps, limits, brake, and conditions of a stop."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

from cablewright.machine.drives import objects as o
from cablewright.machine.drives.can_bus import CanFrame
from cablewright.machine.drives.cia402 import ENERGISED, IN_FAULT, PowerState
from cablewright.machine.drives.objects import Mode
from cablewright.machine.drives.virtual.dictionary import Dictionary, entries_of

HEARTBEAT_LOST, NO_COMMAND, FOLLOWING, SHORT_PDO = 0x8130, 0x8250, 0x8611, 0x8210

_STATUS: Final = {
    PowerState.NOT_READY: 0x00,
    PowerState.DISABLED: 0x40,
    PowerState.READY: 0x21,
    PowerState.SWITCHED_ON: 0x23,
    PowerState.ENABLED: 0x27,
    PowerState.QUICK_STOP: 0x07,
    PowerState.FAULT_REACTION: 0x0F,
    PowerState.FAULT: 0x08,
}
_REMOTE: Final = 0x0210  # voltage is there, and the bus commands
_STAYS: Final = 5  # of the quick stop's options: those from it on end in the state of a quick stop
_STOPPED: Final = 1e-9  # counts/s
_BRAKE_BIT, _CHAIN_BIT = 16, 17  # of the digital inputs


@dataclass(eq=False)
class VirtualDrive:
    """One virtual servo drive.

    Positions are counts of its motor, by its own sign; torques N m of the motor. ``load``: N m that its motor has to
    hold, of the sign that would turn it by itself; ``speed``: counts/s at which it turns now. Both are for the plant
    behind it.
    """

    node: int
    rated_torque: float
    counts: int
    speed_unit: float  # of 0x60FF, for a turn a second
    brake_time: float = 0.1  # to open and to close, s
    mobility: float = 1.0  # counts/s of a motor that is not held, for a N m too much
    position: float = 0.0
    load: float = 0.0
    speed: float = 0.0
    state: PowerState = PowerState.DISABLED
    brake_closed: bool = True
    chain_closed: bool = True
    stop_input: bool = False  # its own input for a quick stop
    tells_early: bool = False  # it reports that it is disabled, or in fault, while its brake still closes under torque
    drift: float = 0.0  # counts/s by which it turns besides, unknown to itself
    keeps_outputs: bool = False  # in a fault, instead of clearing them
    dead: bool = False  # neither hears nor says anything
    profile: int = o.PROFILE
    dictionary: Dictionary = field(init=False)
    nmt: int = o.PREOPERATIONAL
    outbox: list[CanFrame] = field(default_factory=list)
    _edge: bool = False  # bit 7 of the last controlword
    _opening: float = math.inf  # s of operation left until the brake is open
    _closing: bool = False  # becoming disabled
    _holds: bool = False  # torque, though it reports that it is disabled
    _closes_in: float = math.inf  # s until the brake has closed, since its coil lost current
    _wanted: float = 0.0  # counts/s, after the ramp
    _error: float = 0.0  # counts that it is behind its target
    _off_window: float = 0.0  # s
    _beat_heard: float = math.nan  # s; NaN: the consumer is not armed
    _commanded: float = math.nan  # s, of the last PDO
    _beaten: float = -math.inf

    def __post_init__(self) -> None:
        """A new drive, with the values of its factory."""
        entries = entries_of(0x1000 + self.node, self.rated_torque, self.counts)
        self.dictionary = Dictionary(self.node, entries, lambda: self.nmt == o.OPERATIONAL)

    @property
    def torque(self) -> float:
        """Torque of the motor, N m, within its limit; none behind a closed brake."""
        if self.brake_closed or not self._powered:
            return 0.0
        limit = self.dictionary[o.MAX_TORQUE] * 1e-3 * self.rated_torque
        return min(max(-self.load, -limit), limit)

    @property
    def outputs(self) -> int:
        """The bits of its digital outputs that are set."""
        cleared = self.state in IN_FAULT and not self.keeps_outputs
        return 0 if cleared else self.dictionary[o.OUTPUTS] & self.dictionary[o.OUTPUT_MASK]

    @property
    def _powered(self) -> bool:
        return self.state in ENERGISED or self._holds

    def fail(self, code: int) -> None:
        """Report a fault: stop by the ramp, then close the brake, then remove torque."""
        if self.state in IN_FAULT:
            return
        self.dictionary[o.ERROR_CODE] = code
        stops = self._powered and not self.brake_closed
        self.state, self._closing = PowerState.FAULT_REACTION if stops else PowerState.FAULT, False
        if not stops:
            self._drop_brake()
        self.outbox.append(CanFrame(o.SYNC + self.node, code.to_bytes(2, "little") + bytes(6)))

    def restart(self) -> None:
        """Simulate a loss and return of power: factory values; the position of the motor is kept."""
        self.state, self.brake_closed, self.nmt = PowerState.DISABLED, True, o.PREOPERATIONAL
        self._closing, self._holds, self._closes_in = False, False, math.inf
        self.speed = self._wanted = self._error = 0.0
        self._beat_heard = self._commanded = math.nan
        self.__post_init__()
        self.outbox.append(CanFrame(o.HEARTBEAT + self.node, bytes([o.BOOTED])))

    def hear(self, frame: CanFrame, now: float) -> None:
        """Process a frame of the bus at *now*, s."""
        if self.dead:
            return
        data = frame.data
        if frame.id == o.NMT and len(data) == 2 and data[1] in (0, self.node):
            states = {o.NMT_START: o.OPERATIONAL, o.NMT_PREOPERATIONAL: o.PREOPERATIONAL}
            self.nmt = states.get(data[0], self.nmt)
            if self.nmt != o.OPERATIONAL:
                self._commanded = math.nan
        elif frame.id == o.SDO_REQUEST + self.node:
            answer = self._ask(data)
            self.outbox += [] if answer is None else [answer]
            if self.dictionary[o.CONSUMER_HEARTBEAT] == 0:
                self._beat_heard = math.nan
        elif o.HEARTBEAT <= frame.id == o.HEARTBEAT + (self.dictionary[o.CONSUMER_HEARTBEAT] >> 16 & 0x7F):
            self._beat_heard = now
        elif self.nmt == o.OPERATIONAL:
            self._hear_pdo(frame, now)

    def object_answer(self, request: bytes) -> bytes | None:
        """Return the answer to a mailbox request for an object, in which a text is whole."""
        answer = self._ask(request)
        return None if answer is None else answer.data + self.dictionary.rest()

    def _ask(self, request: bytes) -> CanFrame | None:
        self._refresh()
        answer = self.dictionary.answer(request)
        if request[:1] != b"\x40" and request[1:3] == o.CONTROLWORD.index.to_bytes(2, "little"):
            self._control(self.dictionary[o.CONTROLWORD])
        return answer

    def _hear_pdo(self, frame: CanFrame, now: float) -> None:
        own = self.dictionary
        if frame.id == o.SYNC:
            self.outbox += self._answers()
            return
        for k in range(len(o.TO_DRIVES)):
            if own.entries[0x1400 + k, 1].data == frame.id.to_bytes(4, "little"):
                self.command(0x1600 + k, frame.data, now)

    def command(self, mapping: int, data: bytes, now: float) -> None:
        """Process a PDO with that *mapping* at *now*, s."""
        entries = self.dictionary.mapped(mapping)
        if len(data) != sum(len(each.data) for each in entries):
            self.fail(SHORT_PDO)
            return
        at = 0
        for each in entries:
            each.data = data[at : at + len(each.data)]
            at += len(each.data)
        if mapping == 0x1600:
            self._commanded = now
            self._control(self.dictionary[o.CONTROLWORD])

    def told(self, mapping: int) -> bytes:
        """Return the bytes of the PDO with that *mapping* that the drive sends."""
        return b"".join(each.data for each in self._refresh().mapped(mapping))

    def _answers(self) -> list[CanFrame]:
        cobs = [
            int.from_bytes(self.dictionary.entries[0x1800 + k, 1].data, "little") for k in range(len(o.FROM_DRIVES))
        ]
        return [CanFrame(cob & 0x7FF, self.told(0x1A00 + k)) for k, cob in enumerate(cobs) if not cob >> 31]

    def _refresh(self) -> Dictionary:
        """Update its reported state."""
        own, limit = self.dictionary, 1e3 / self.rated_torque
        own[o.STATUSWORD] = _STATUS[self.state] | _REMOTE
        wrapped = (math.floor(self.position) + (1 << 31)) % (1 << 32) - (1 << 31)
        own[o.POSITION] = wrapped
        own[o.VELOCITY] = round(self.speed * self.speed_unit / self.counts)
        own[o.TORQUE] = round(self.torque * limit)
        own[o.FOLLOWING_ERROR] = round(self._error)
        own[o.INPUTS] = self.brake_closed << _BRAKE_BIT | self.chain_closed << _CHAIN_BIT
        return own

    def _control(self, word: int) -> None:
        """Take the transition that a controlword asks for."""
        rising, self._edge = bool(word & 0x80) and not self._edge, bool(word & 0x80)
        state = self.state
        if state is PowerState.FAULT:
            if rising:
                self.state, self._holds = PowerState.DISABLED, False
                self.dictionary[o.ERROR_CODE] = 0
            return
        if state is PowerState.FAULT_REACTION:
            return
        command = word & 0x0F
        if command & 0x02 == 0:
            self._power_off(at_once=True)
        elif command & 0x04 == 0:
            if state is PowerState.ENABLED:
                self.state = PowerState.QUICK_STOP
        elif command & 0x01 == 0:
            self._shut_down(state)
        elif command == 0x0F:
            self._enable(state)
        else:
            self._switch_on(state)

    def _shut_down(self, state: PowerState) -> None:
        if state in (PowerState.DISABLED, PowerState.SWITCHED_ON):
            self.state, self._holds = PowerState.READY, False  # torque goes, whatever the brake does
        elif state is PowerState.ENABLED:
            self._power_off(at_once=self.dictionary[o.SHUTDOWN_OPTION] == 0)

    def _switch_on(self, state: PowerState) -> None:
        if state is PowerState.READY:
            self.state = PowerState.SWITCHED_ON
        elif state is PowerState.ENABLED:
            self._power_off(at_once=self.dictionary[o.DISABLE_OPTION] == 0)

    def _enable(self, state: PowerState) -> None:
        holds = self.dictionary[o.QUICK_STOP_OPTION] >= _STAYS
        if state is PowerState.SWITCHED_ON:
            self.state, self._opening, self._closing = PowerState.ENABLED, self.brake_time, False
            self._holds, self._closes_in = False, math.inf
            self._wanted = self._error = 0.0
        elif state is PowerState.QUICK_STOP and holds and not self.stop_input:
            self.state = PowerState.ENABLED
        elif state is PowerState.ENABLED and math.isinf(self._closes_in):
            self._closing = False

    def _power_off(self, *, at_once: bool) -> None:
        if not at_once:
            self._closing = True
            return
        self.state, self._closing, self._holds = PowerState.DISABLED, False, False
        self._drop_brake()

    def _drop_brake(self) -> None:
        if not self.brake_closed:
            self._closes_in = min(self._closes_in, self.brake_time)

    def tick(self, now: float, dt: float) -> None:
        """Advance by *dt*, s, to *now*: supervision, ramps, and the `speed` for the plant."""
        if not self.dead:
            self._watch(now)
        self._brake(dt)
        self._move(dt)
        self._follow(dt)

    def _watch(self, now: float) -> None:
        own = self.dictionary
        limit = (own[o.CONSUMER_HEARTBEAT] & 0xFFFF) * 1e-3
        if limit and now - self._beat_heard > limit + 1e-9:
            self._beat_heard = math.nan
            if own[o.ABORT_OPTION]:
                self.fail(HEARTBEAT_LOST)
        timeout = int.from_bytes(own.entries[0x1400, 5].data, "little") * 1e-3
        if timeout and now - self._commanded > timeout + 1e-9:
            self._commanded = math.nan
            self.fail(NO_COMMAND)
        interval = own[o.PRODUCER_HEARTBEAT] * 1e-3
        if interval and now - self._beaten >= interval - 1e-9:
            self._beaten = now
            self.outbox.append(CanFrame(o.HEARTBEAT + self.node, bytes([self.nmt])))

    def _brake(self, dt: float) -> None:
        if self.stop_input and self.state is PowerState.ENABLED:
            self.state = PowerState.QUICK_STOP
        if self.state is PowerState.ENABLED and self.brake_closed and not self._closing:
            self._opening -= dt
            if self._opening <= 1e-9:
                self.brake_closed = False
        if self.brake_closed or abs(self._wanted) < _STOPPED:
            self._close_brake(dt)
        elif math.isfinite(self._closes_in):
            self._closes_in -= dt  # it drops while the motor turns
        if self._closes_in <= 1e-9:
            self.brake_closed, self._closes_in = True, math.inf

    def _close_brake(self, dt: float) -> None:
        """Of a motor that stands: close the brake under torque, then be off."""
        faulty, leaves = self.state is PowerState.FAULT_REACTION, self._closing and self.state is PowerState.ENABLED
        if faulty or leaves:
            self._drop_brake()
        if math.isfinite(self._closes_in):
            self._closes_in -= dt
        done = self.brake_closed or self._closes_in <= 1e-9
        if (faulty or leaves) and (done or self.tells_early):
            self.state, self._closing = PowerState.FAULT if faulty else PowerState.SWITCHED_ON, False
            self._holds = not done
        elif done:
            self._holds = False

    def _move(self, dt: float) -> None:
        """The speed of the motor: of its target, by ramps, limits and load."""
        own = self.dictionary
        if self.brake_closed:
            self.speed = self._wanted = 0.0
            return
        if not self._powered:  # nothing holds the load
            self.speed = self._wanted = self.mobility * self.load
            return
        unit = self.counts / self.speed_unit
        most = own[o.MAX_MOTOR_SPEED] * self.counts / 60.0
        stops = self.state is not PowerState.ENABLED or self._closing
        limit = own[o.MAX_TORQUE] * 1e-3 * self.rated_torque
        if stops:
            change = own[o.STOP_DECELERATION] * unit * dt
            self._wanted = math.copysign(max(abs(self._wanted) - change, 0.0), self._wanted)
        elif own[o.MODE] == Mode.TORQUE:
            asked = min(max(own[o.TARGET_TORQUE] * 1e-3 * self.rated_torque, -limit), limit)
            free = self.mobility * (asked + self.load)
            self._wanted = min(max(free, -most), most)
            own[o.MODE_SHOWN] = Mode.TORQUE
            self.speed = self._wanted
            return
        else:
            own[o.MODE_SHOWN] = own[o.MODE]
            self._wanted = own[o.TARGET_VELOCITY] * unit if own[o.MODE] == Mode.VELOCITY else 0.0
            self._wanted = min(max(self._wanted, -most), most)
        slip = abs(self.load) - limit
        self.speed = self._wanted + self.drift + (math.copysign(self.mobility * slip, self.load) if slip > 0.0 else 0.0)

    def _follow(self, dt: float) -> None:
        own = self.dictionary
        if self.state is not PowerState.ENABLED or own[o.MODE] != Mode.VELOCITY:
            self._error = self._off_window = 0.0
            return
        self._error += (self._wanted + self.drift - self.speed) * dt
        self._off_window = self._off_window + dt if abs(self._error) > own[o.FOLLOWING_WINDOW] else 0.0
        if self._off_window > own[o.FOLLOWING_TIME] * 1e-3:
            self.fail(FOLLOWING)
