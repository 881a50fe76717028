"""Virtual drives and this client beside an independent CANopen, canopen of python-can, on python-can's virtual bus."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import can
import canopen
import pytest
from canopen.objectdictionary import ObjectDictionary, ODVariable, datatypes

from cablewright.foundation.errors import EnvironmentFault
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.axis import Axis
from cablewright.machine.drives.can_port import CanPort
from cablewright.machine.drives.canopen_network import Network
from cablewright.machine.drives.drum_units import Scale
from cablewright.machine.drives.local_can_bus import Hub, LoopbackPort
from cablewright.machine.drives.object_transfers import Transfer
from cablewright.machine.drives.virtual.virtual_drive import VirtualDrive

SCALE = Scale(1.0, 1.0, 1.0, 1.0, (0.05, 0.05), 1.0, 1.0)
TYPES = {(1, False): datatypes.UNSIGNED8, (2, False): datatypes.UNSIGNED16, (4, False): datatypes.UNSIGNED32}


def opened(channel: str) -> can.BusABC:
    return can.Bus(interface="virtual", channel=channel, receive_own_messages=False)


@pytest.fixture
def drive(request: pytest.FixtureRequest) -> Iterator[VirtualDrive]:
    """A virtual drive on a bus of its own, on a thread."""
    found, over = VirtualDrive(5, 0.5, 1024, 1024.0), threading.Event()
    port = CanPort(opened(request.node.name))

    def work() -> None:
        while not over.is_set():
            frame = port.receive(port.now() + 0.01)
            if frame is not None:
                found.hear(frame, port.now())
            for answer in found.outbox:
                port.send(answer)
            found.outbox.clear()

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    yield found
    over.set()
    thread.join(timeout=5.0)
    port.close()


def test_another_client_reads_and_writes_a_virtual_drive(drive: VirtualDrive, request: pytest.FixtureRequest) -> None:
    network = canopen.Network()
    network.connect(interface="virtual", channel=request.node.name)
    try:
        node = network.add_node(5, ObjectDictionary())
        node.sdo.RESPONSE_TIMEOUT = 2.0
        assert node.sdo.upload(0x1000, 0) == (0x00020192).to_bytes(4, "little")
        assert node.sdo.upload(0x1008, 0) == b"cablewright virtual drive"  # in segments
        node.sdo.download(0x605A, 0, (6).to_bytes(2, "little"))
        assert node.sdo.upload(0x605A, 0) == b"\x06\x00"
        assert drive.dictionary[o.QUICK_STOP_OPTION] == 6
        with pytest.raises(canopen.SdoAbortedError, match="Object does not exist"):
            node.sdo.upload(0x2222, 0)
        with pytest.raises(canopen.SdoAbortedError, match="write a read only"):
            node.sdo.download(0x6076, 0, bytes(4))
        node.nmt.send_command(o.NMT_START)
        deadline = time.monotonic() + 5.0
        while drive.nmt != o.OPERATIONAL and time.monotonic() < deadline:
            time.sleep(0.01)
        assert drive.nmt == o.OPERATIONAL
    finally:
        network.disconnect()


def test_this_client_reads_and_writes_another_server(request: pytest.FixtureRequest) -> None:
    dictionary = ObjectDictionary()
    for kind, value in ((o.DEVICE_TYPE, 0x00020192), (o.MAX_TORQUE, 500), (o.SERIAL, 77)):
        variable = ODVariable(kind.name, kind.index, kind.sub)
        variable.data_type, variable.default = TYPES[kind.size, kind.signed], value
        dictionary.add_object(variable) if not kind.sub else None
    name = ODVariable("device name", 0x1008, 0)
    name.data_type, name.default = datatypes.VISIBLE_STRING, "a drive of another make"
    dictionary.add_object(name)
    server = canopen.Network()
    server.connect(interface="virtual", channel=request.node.name)
    try:
        node = server.create_node(9, dictionary)
        axis = Axis("line", 9, SCALE)
        bus = Network(CanPort(opened(request.node.name)), (axis,), 127, 0.2)
        kinds = (Transfer(o.DEVICE_TYPE), Transfer(o.DEVICE_NAME), Transfer(o.MAX_TORQUE, 321), Transfer(o.VENDOR))
        read = [axis.transfers.add(each) for each in kinds]
        bus.finish(axis)
        assert (read[0].result, read[1].text, read[2].failure) == (0x00020192, "a drive of another make", "")
        assert node.sdo[0x6072].raw == 321
        assert read[3].absent
        found = bus.identify(9)
        assert found is not None
        assert (found.profile, found.name, found.twice) == (402, "a drive of another make", False)
        assert bus.identify(10) is None
        bus.port.close()
    finally:
        server.disconnect()


def test_a_bus_that_cannot_be_opened_says_what_to_do() -> None:
    with pytest.raises(EnvironmentFault, match="ip link set can77 up type can bitrate 500000"):
        CanPort.opened("socketcan", "can77", 500_000)
    with pytest.raises(EnvironmentFault, match="the bus nonsense can0 cannot be opened"):
        CanPort.opened("nonsense", "can0", 500_000)
    with pytest.raises(EnvironmentFault, match="--virtual FILE"):
        LoopbackPort(9)


def test_what_strangers_send_to_the_hub_is_no_frame() -> None:
    import socket

    hub = Hub(0)
    number = hub._socket.getsockname()[1]
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for data in (b"x", bytes(60), b"\xff\xff1234", b"\x05\x06" + bytes(9)):
        sender.sendto(data, ("127.0.0.1", number))
    assert hub.receive(hub.now() + 0.05) is None
    sender.sendto(b"\x05\x06ab", ("127.0.0.1", number))
    found = hub.receive(hub.now() + 1.0)
    assert found == (0x605, b"ab")
    with pytest.raises(EnvironmentFault, match="cannot be opened"):
        Hub(number)
    hub.close()
    sender.close()
