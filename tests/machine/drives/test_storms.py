"""Many simultaneous faults: whatever frames are lost, late or doubled, no load is ever without torque and brake."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.foundation.signals import WinchMode
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.can_bus import CanFrame
from cablewright.machine.interface import RESET
from cases import some
from virtual_drives import SPEEDS, Bench, bench, braked

MODES = (WinchMode.OFF, WinchMode.HOLD, WinchMode.VELOCITY, WinchMode.TENSION)


class Storm:
    """Loses, delays and doubles frames at random while it is on."""

    def __init__(self, seed: int, share: float) -> None:
        self.random, self.share, self.on = np.random.default_rng(seed), share, False

    def __call__(self, _frame: CanFrame, _now: float) -> tuple[float, ...]:
        if not self.on or self.random.random() > self.share:
            return (0.0,)
        late = float(self.random.exponential(0.02))
        return ((), (late,), (0.0, late))[int(self.random.integers(3))]


def watch(found: Bench) -> list[str]:
    """What must never be, at each tick from now on."""
    seen: list[str] = []
    advance = found.rig.advance

    def watched(now: float | None = None) -> list[CanFrame]:
        said = advance(now)
        for name, drive in zip(found.rig.names, found.rig.drives, strict=True):
            if not drive.brake_closed and not drive._powered:
                seen.append(f"{found.rig.now:.3f} s: {name} hangs on nothing")
        if found.rig.plant.truth.tensions.max() > 2000.0:
            seen.append(f"{found.rig.now:.3f} s: over its limit")
        return said

    found.rig.advance = watched  # type: ignore[method-assign]
    return seen


@pytest.mark.parametrize("seed", some(range(6)))
def test_in_any_storm_a_load_has_torque_or_a_brake(seed: int) -> None:
    """Random orders in a storm of a random strength, with drives that fault, stop and are cut off meanwhile."""
    random = np.random.default_rng([seed, 7])
    storm = Storm(seed, float(random.choice((0.01, 0.05, 0.3))))
    found = bench(disturb=storm)
    for drive in found.rig.drives:
        drive.tells_early = bool(random.integers(2))
    found.machine.open()
    found.step(steps=25)
    seen, storm.on = watch(found), True
    for _ in range(25):
        mode = MODES[int(random.integers(4))]
        speeds = random.uniform(-1.0, 1.0) * np.array(SPEEDS) if mode is WinchMode.VELOCITY else None
        more = {"tensions": np.full(4, 30.0)} if mode is WinchMode.TENSION else {}
        if mode is WinchMode.OFF and random.random() < 0.7:
            more = {"outputs": {RESET: 1.0}}
        found.step(mode, speeds, int(random.integers(1, 30)), **more)
        drive = found.rig.drives[int(random.integers(4))]
        harm = random.random()
        if harm < 0.1:
            drive.fail(0x2310)
        elif harm < 0.2:
            drive.stop_input = not drive.stop_input
    storm.on = False
    found.step(WinchMode.OFF, steps=150)
    assert braked(found)
    angles = found.rig.plant.rig.winches.angles
    found.step(WinchMode.VELOCITY, SPEEDS, 1)
    if found.machine.tripped:
        found.step(WinchMode.VELOCITY, SPEEDS, 50)
        assert np.abs(found.rig.plant.rig.winches.angles - angles).max() < 1e-6
    found.machine.close()
    assert braked(found)
    assert not seen


@pytest.mark.parametrize("what", ["lost", "late", "doubled"])
@pytest.mark.parametrize("kind", [o.SDO_REQUEST, o.SDO_ANSWER])
def test_a_request_that_is_lost_late_or_doubled_enables_all_or_none(kind: int, what: str) -> None:
    """Each of them in turn while parameters are written: a name and a reason, or all of them as they should be."""
    delays = {"lost": (), "late": (0.03,), "doubled": (0.0, 0.0)}[what]
    outcomes = set()
    for which in range(3, 100, 24):
        count = [-1000]

        def disturb(frame: CanFrame, _now: float, count: list[int] = count, which: int = which) -> tuple[float, ...]:
            if frame.id != kind + 2:
                return (0.0,)
            count[0] += 1
            return delays if count[0] == which else (0.0,)

        found = bench(disturb=disturb)
        found.machine.open()
        found.step(steps=25)
        seen, count[0] = watch(found), 0
        found.rig.drives[1].dictionary[o.FAULT_OPTION] = 0  # to be written again
        found.rig.drives[1].dictionary[o.MAX_TORQUE] = 5000
        found.step(WinchMode.VELOCITY)
        outcomes.add(bool(found.machine.tripped))
        if found.machine.tripped:
            assert "south-east" in found.machine.tripped
            found.step(WinchMode.OFF, steps=60)
            assert braked(found)
        else:
            assert not any(drive.brake_closed for drive in found.rig.drives)
            assert found.rig.drives[1].dictionary[o.FAULT_OPTION] == 2
            assert found.rig.drives[1].dictionary[o.MAX_TORQUE] < 1500
        assert not seen
    assert outcomes == ({False, True} if what == "lost" else {False})
