"""An EtherCAT ring at a network interface, by pysoem, whose SOEM is under the GPL: of the extra ``ethercat``."""

from __future__ import annotations

import contextlib
import socket
import sys
import time
from collections.abc import Sequence
from typing import Any, Final

from cablewright.foundation.errors import EnvironmentFault
from cablewright.machine.drives.ethercat.registers import FIRST_OBJECT, INPUT_START
from cablewright.machine.drives.object_transfers import TIMEOUT, Transfer, Transfers, text_of
from cablewright.machine.drives.objects import Object

INIT, PREOP, SAFEOP, OP = 1, 2, 4, 8
STATES: Final = {INIT: "init", PREOP: "pre-operational", SAFEOP: "safe-operational", OP: "operational"}
ERROR: Final = 0x10
"""Of a state: the device has left a higher one by itself, until the master acknowledges it."""

_ETHERTYPE: Final = 0x88A4
_PATIENCE: Final = 0.1  # of the time for an answer, for one frame to come back
_PATIENT: Final = 0.02  # s for a mailbox to take a message, and for an EEPROM, at least
_STATE_TIME: Final = 0.5  # s for all devices to reach a state


class Ring:
    """The devices of a ring by their position, from 0 on. Nothing is sent before `enumerate_devices`."""

    def __init__(self, master: Any, soem: Any, patience: float) -> None:
        """*master*: master object of the module *soem*, with its interface open.

        *patience*: s for a frame to come back.
        """
        self._master, self._soem, self._patience = master, soem, round(1e6 * patience)
        self._inputs: list[tuple[int, int]] = []  # start and length in each device

    @classmethod
    def opened(cls, interface: str, answer_timeout: float, listen: float) -> Ring:
        """Listen for *listen*, s, and open the interface. Raises `EnvironmentFault`, with the setup to do."""
        try:
            import pysoem
        except ImportError:
            why = "EtherCAT drives need pysoem, whose SOEM is under the GPL: pip install 'cablewright[ethercat]'"
            raise EnvironmentFault(f"drives.interface = {interface!r}: {why}") from None
        if heard(interface, listen):
            raise EnvironmentFault(f"drives: another master sends on {interface}; end it first")
        patience = _PATIENCE * answer_timeout
        times = pysoem.settings.timeouts
        times.ret = round(1e6 * patience)
        times.safe = times.eeprom = times.tx_mailbox = round(1e6 * max(answer_timeout, _PATIENT))
        master = pysoem.Master()
        try:
            master.open(interface)
        except ConnectionError:
            raise EnvironmentFault(_closed(interface, "it is not there, or not to be opened")) from None
        master.sdo_read_timeout = master.sdo_write_timeout = round(1e6 * max(answer_timeout, TIMEOUT))
        return cls(master, pysoem, patience)

    def enumerate_devices(self) -> int:
        """Bring all devices to init and on to pre-operational, which stops drives; return their number."""
        number = max(int(self._master.config_init(release_gil=True)), 0)
        for device in self._devices:
            device.add_emergency_callback(lambda _message: None)  # the error code comes with the process data
        self._reach(PREOP)
        return number

    @property
    def _devices(self) -> Sequence[Any]:
        return self._master.slaves or ()

    def carry_out(self, transfers: Transfers, position: int) -> None:
        """Carry out all parameter *transfers* of a device of the ring, one after the other."""
        while (transfer := transfers.first) is not None:
            try:
                self._transfer(transfer, position)
            except self._soem.SdoError as error:
                transfers.abort(transfer, error.abort_code & 0xFFFFFFFF)
            except (self._soem.WkcError, self._soem.MailboxError, self._soem.PacketError):
                transfers.end(transfer, "does not answer")
            else:
                transfers.end(transfer, self._misfit(transfer))

    def _transfer(self, transfer: Transfer, position: int) -> None:
        device, kind = self._devices[position], transfer.object
        if transfer.value is not None and kind.index < FIRST_OBJECT:
            device._fpwr(kind.index, kind.pack(transfer.value), self._patience)  # noqa: SLF001
        elif transfer.value is not None:
            device.sdo_write(kind.index, kind.sub, kind.pack(transfer.value), release_gil=True)
        else:
            data = self._read(device, kind)
            transfer.result, transfer.text = kind.unpack(data), text_of(data) if kind.size == 0 else ""
            transfer.length = len(data)

    def _read(self, device: Any, kind: Object) -> bytes:
        if kind.index < FIRST_OBJECT:
            return bytes(device._fprd(kind.index, kind.size, self._patience))  # noqa: SLF001  # no other way to registers
        return bytes(device.sdo_read(kind.index, kind.sub, release_gil=True))

    @staticmethod
    def _misfit(transfer: Transfer) -> str:
        size = transfer.object.size
        fits = transfer.value is not None or size in (0, transfer.length)
        return "" if fits else f"has {transfer.length} bytes, not {size}"

    def map_process_data(self) -> list[tuple[int, int]]:
        """Set up sync managers, bring all to safe-operational; return the bytes of each device's outputs and inputs.

        Raises `EnvironmentFault` for a device that does not get there.
        """
        try:
            self._master.config_map()
        except self._soem.ConfigMapError as error:
            raise EnvironmentFault(f"drives: the ring cannot be set up: {error.error_list[0]}") from None
        self._reach(SAFEOP)
        found = [(len(device.output), len(device.input)) for device in self._devices]
        starts = [INPUT_START.unpack(self._read(device, INPUT_START)) for device in self._devices]
        self._inputs = [(start, size) for start, (_, size) in zip(starts, found, strict=True)]
        return found

    def exchange(self, outputs: Sequence[bytes]) -> list[bytes | None]:
        """Send outputs, and take the inputs of each device; None: it did not take part.

        Where the working counter is wrong each device is asked alone. Raises `OSError` where no frame comes back.
        """
        for device, data in zip(self._devices, outputs, strict=True):
            device.output = data
        self._master.send_processdata()
        counted = self._master.receive_processdata(self._patience, release_gil=True)
        if counted == self._master.expected_wkc:
            return [bytes(device.input) for device in self._devices]
        found = self.ask()
        if counted < 0 and not any(found):
            raise OSError("no frame comes back")
        return found

    def ask(self) -> list[bytes | None]:
        """Read the inputs of each device alone, which does not reset a watchdog."""
        found: list[bytes | None] = []
        for device, (start, size) in zip(self._devices, self._inputs, strict=True):
            try:
                found.append(bytes(device._fprd(start, size, self._patience)))  # noqa: SLF001
            except self._soem.WkcError:
                found.append(None)
        return found

    def states(self) -> list[int]:
        """The state of each device; 0: it does not answer."""
        self._master.read_state()
        return [int(device.state) for device in self._devices]

    def cause(self, position: int) -> str:
        """Return the reason why a device is in another state than the requested one."""
        return str(self._soem.al_status_code_to_string(self._devices[position].al_status))

    def request(self, position: int, state: int) -> None:
        """Request a state of a device; with `ERROR`, also acknowledge its error."""
        device = self._devices[position]
        device.state = state
        device.write_state()

    def leave(self) -> None:
        """Bring all devices of the EtherCAT ring back to init; raises nothing."""
        for state in (SAFEOP, INIT):
            self._master.state = state
            self._master.write_state()

    def _reach(self, state: int) -> None:
        """Wait until all devices are in a state. Raises `EnvironmentFault`."""
        end = time.monotonic() + _STATE_TIME
        while True:
            found = self.states()
            late = [k for k, each in enumerate(found) if each & 0x0F < state or each & ERROR]
            if not late:
                return
            if time.monotonic() > end:
                why = f"does not become {STATES[state]}: {self.cause(late[0])}"
                raise EnvironmentFault(f"drives: the device at position {late[0] + 1} of the ring {why}")
            time.sleep(0.005)

    def close(self) -> None:
        """Leave the network interface of the EtherCAT ring."""
        self._master.close()


def heard(interface: str, seconds: float) -> bool:
    """Return whether frames of EtherCAT arrive during this time, before any was sent. Raises `EnvironmentFault`."""
    if sys.platform != "linux":  # elsewhere there is no such socket, and another master is not heard
        return False
    try:
        with contextlib.closing(socket.socket(socket.AF_PACKET, socket.SOCK_RAW)) as ear:
            ear.bind((interface, _ETHERTYPE))
            ear.settimeout(seconds)
            return bool(ear.recv(64))
    except TimeoutError:
        return False
    except OSError as error:
        raise EnvironmentFault(_closed(interface, error.strerror or str(error))) from None


def _closed(interface: str, why: str) -> str:
    hint = f"ip link set {interface} up, and run as root or with CAP_NET_RAW"
    return f"drives: the interface {interface} cannot be opened: {why}; {hint}"
