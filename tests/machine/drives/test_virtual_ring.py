"""The emulated EtherCAT ring without a network: its slaves handle datagrams, and data that are none."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from cablewright.machine.drives.virtual import slave_memory as m
from cablewright.machine.drives.virtual.ethercat_ring import VirtualRing
from cablewright.machine.drives.virtual.rig import VirtualRig
from cablewright.robot import load
from virtual_drives import RING_BEGIN, virtual_twin

HEAD = b"\xff" * 6 + bytes(6) + b"\x88\xa4"


@pytest.fixture(scope="module")
def rig() -> VirtualRig:
    return VirtualRig(load("merlet2023"), virtual_twin(), RING_BEGIN["merlet2023"])


@pytest.fixture
def ring(rig: VirtualRig) -> VirtualRing:
    return VirtualRing(rig)


def frame(*datagrams: tuple[int, int, int, bytes]) -> bytes:
    """A frame of commands, addresses, offsets and data."""
    body = b""
    for k, (command, address, offset, data) in enumerate(datagrams):
        more = 0x8000 if k < len(datagrams) - 1 else 0
        body += struct.pack("<BBHHHH", command, k, address, offset, len(data) | more, 0) + data + bytes(2)
    return HEAD + struct.pack("<H", 0x1000 | len(body)) + body


def answers(back: bytes, *sizes: int) -> list[tuple[bytes, int]]:
    """Data and working counter of each datagram."""
    found, at = [], 16
    for size in sizes:
        data = back[at + 10 : at + 10 + size]
        found.append((data, int.from_bytes(back[at + 10 + size : at + 12 + size], "little")))
        at += 12 + size
    return found


def test_all_are_counted_found_by_place_and_given_addresses(ring: VirtualRing) -> None:
    back = ring.passed(frame((7, 0, m.AL_STATUS, bytes(2))), 0.0)
    assert back is not None
    assert answers(back, 2) == [(b"\x01\x00", 4)]  # all in init
    writes = [(2, (1 - k) & 0xFFFF, m.STATION, struct.pack("<H", 0x1000 + k)) for k in range(1, 5)]
    back = ring.passed(frame(*writes, (4, 0x1003, m.STATION, bytes(2)), (4, 0x1009, m.STATION, bytes(2))), 0.0)
    assert back is not None
    assert [count for _, count in answers(back, 2, 2, 2, 2, 2, 2)] == [1, 1, 1, 1, 1, 0]
    assert answers(back, 2, 2, 2, 2, 2)[4][0] == struct.pack("<H", 0x1003)


def test_no_state_is_skipped_on_the_rise_to_operational(ring: VirtualRing) -> None:
    back = ring.passed(frame((8, 0, m.AL_CONTROL, b"\x08\x00"), (7, 0, m.AL_STATUS, bytes(6))), 0.0)
    assert back is not None
    status = answers(back, 2, 6)[1][0]
    assert (status[0], status[4]) == (0x11, 0x11)  # still in init, with an error: invalid requested state change
    back = ring.passed(frame((8, 0, m.AL_CONTROL, b"\x12\x00"), (7, 0, m.AL_STATUS, bytes(6))), 0.0)
    assert back is not None
    assert answers(back, 2, 6)[1][0][0] == 0x02  # acknowledged


def test_frames_that_are_none_come_back_as_they_are_or_not_at_all(ring: VirtualRing) -> None:
    rng = np.random.default_rng(5)
    whole = frame((7, 0, 0, bytes(8)), (2, 0, m.EEPROM_CONTROL, bytes(6)), (12, 0, 0, bytes(40)))
    for length in range(len(whole)):
        assert ring.passed(whole[:length], 0.0) is None
    for _ in range(3000):
        junk = bytearray(whole)
        for at in rng.integers(14, len(junk), 6):
            junk[at] = rng.integers(256)
        back = ring.passed(bytes(junk), 0.0)
        assert back is None or len(back) == len(junk)
