"""A job printed on virtual drives in a run folder, by orders that are typed: nothing moves without one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import PrintState
from cablewright.live.drives.actions import enable, home, jog_platform, jog_winch, scan, show
from cablewright.live.drives.printing import print_on_drives
from cablewright.live.prints.print_job import PrintedJob
from cablewright.live.serve.operated_machines import DriveStation
from cablewright.machine.drives.virtual.rig import VirtualPort, VirtualRig
from cablewright.machine.log.log import read_log
from cablewright.printing.job import Job, Motion
from terminal_user import WORDS, Typist
from virtual_drives import RING, RING_BEGIN, Bench, bench, virtual_twin

SMALL = RING.model_copy(
    update={
        "origin": (0.65, -0.5, 0.0),
        "helix": RING.helix.model_copy(update={"radius": 0.05}),
        "motion": RING.motion.model_copy(update={"acceleration": 0.4}),
    }
)
"""A ring that begins where `RING` does."""


def printed(found: Bench, folder: Path, typist: Typist, **more: object) -> PrintedJob:
    state = folder / "machine"
    job = more.pop("job", RING)
    return print_on_drives(
        found.robot,
        job,
        folder / "run",
        found.twin.owner,
        state,
        typist,
        inputs={},
        say=typist.said.append,
        port=lambda: found.port,
        **more,
    )  # type: ignore[arg-type]


def homed(folder: Path, **changes: object) -> Bench:
    found = bench(**changes)
    place = found.rig.plant.truth.position
    assert home(found.robot, found.twin.owner, folder / "machine", place, lambda: found.port).status == "done"
    return found


def test_a_ring_is_printed_by_orders_and_its_log_is_that_of_a_real_machine(tmp_path: Path) -> None:
    found = homed(tmp_path)
    typist = Typist({state: list(words) for state, words in WORDS.items()})
    before = found.rig.plant.truth.powder
    answer = printed(found, tmp_path, typist, job=SMALL)
    assert answer.finished, typist.said
    assert any("no valve opens: nothing is laid" in line for line in typist.said)
    assert found.rig.plant.truth.powder == before
    assert not found.rig.valve_open
    assert any("rejected: start: has no effect while the state is off" in line for line in typist.said)
    assert any(line.startswith("no order 'dance'") for line in typist.said)
    assert all(drive.brake_closed for drive in found.rig.drives)
    assert abs(answer.to_dict()["estimated_max_path_error"]) < 2e-3
    with read_log(answer.log) as log:
        assert log.head.kind == "real"
        entries = list(log.entries())
    assert all(entry.truth is None for entry in entries)
    began = next(k for k, entry in enumerate(entries) if entry.progress.state is PrintState.PRINTING)
    assert {order.by for entry in entries for order in entry.orders} == {"terminal"}
    assert not any(entry.command.winch_speeds.any() for entry in entries[: began // 2] if not entry.command.modes)


def test_a_print_pours_where_the_file_names_a_valve_and_says_where_it_cannot(tmp_path: Path) -> None:
    found = homed(tmp_path, valve={"line": "north-east", "bit": 17, "closes_alone": False})
    typist = Typist({state: list(words) for state, words in WORDS.items()})
    before = found.rig.plant.truth.powder
    assert printed(found, tmp_path, typist, job=SMALL).finished, typist.said
    assert not found.rig.valve_open
    assert any("closes_alone = false: its drive leaves it open in a fault" in line for line in typist.said)
    duration = 2.0 * np.pi * SMALL.helix.radius / SMALL.motion.print_speed
    laid = found.twin.owner.point_drum.flow * duration
    poured = before - found.rig.plant.truth.powder
    assert poured == pytest.approx(laid, rel=0.05)  # on while it prints, with ramps laid to half


def test_a_page_shows_the_same_warning_of_the_valve(tmp_path: Path) -> None:
    for valve, says in ((None, "nothing is laid"), ({"line": "north-east", "bit": 17, "closes_alone": False}, "false")):
        found = bench(valve=valve)
        own = found.twin.owner.drives
        station = DriveStation(found.robot, found.twin.owner, tmp_path / "machine", lambda here=found: here.port)
        assert station.sitting(None).notes == ()  # by hand nothing is laid
        assert own is not None
        assert station.sitting(RING).notes == own.valve_notes
        assert says in own.valve_notes[0]
    closes = bench(valve={"line": "north-east", "bit": 17, "closes_alone": True}).twin.owner.drives
    assert closes is not None
    assert closes.valve_notes == ()


def test_without_homing_nothing_moves(tmp_path: Path) -> None:
    found = homed(tmp_path)
    words = {PrintState.FAULT: ["reset"], PrintState.OFF: ["enable"], PrintState.IDLE: ["start"]}
    before = found.rig.plant.truth.position
    answer = printed(found, tmp_path, Typist(words, last=300))
    assert not answer.finished
    assert np.linalg.norm(found.rig.plant.truth.position - before) < 1e-3


@pytest.mark.slow  # as in test_print_loop.py, from its notes
def test_a_print_that_was_left_goes_on_where_it_was(tmp_path: Path) -> None:
    found = homed(tmp_path)
    first = printed(found, tmp_path, Typist({s: list(w) for s, w in WORDS.items()}, last=1100), job=SMALL)
    done = first.record.distance
    assert 0.15 < done < 0.5
    words = {s: list(w) for s, w in WORDS.items()}
    typist = Typist(words, last=6000)
    second = printed(found, tmp_path, typist, job=SMALL, resume=True)
    assert second.finished, typist.said
    assert np.linalg.norm(found.rig.plant.truth.position - RING_BEGIN["merlet2023"]) < 0.02


@pytest.mark.slow  # as a drum is refilled in test_print_loop.py
@pytest.mark.parametrize(("job", "flow"), [(SMALL, 0.15), pytest.param(RING, 0.0376, marks=pytest.mark.slow)])
def test_a_print_waits_for_powder_and_goes_on_when_a_person_says_so(job: Job, flow: float, tmp_path: Path) -> None:
    twin = virtual_twin(flow=flow)
    twin = twin.with_owner(drum=twin.owner.drum.model_copy(update={"powder": 0.4}))
    found = bench()
    rig = VirtualRig(found.robot, twin, RING_BEGIN["merlet2023"])
    port = VirtualPort(rig)
    found = Bench(found.robot, twin, rig, port, found.machine)
    place = rig.plant.truth.position
    assert home(found.robot, twin.owner, tmp_path / "machine", place, lambda: port).status == "done"
    words = {state: list(words) for state, words in WORDS.items()} | {PrintState.REFILLING: ["refilled"] * 99}
    typist = Typist(words, last=2600)
    printed(found, tmp_path, typist, job=job)
    waits = typist.said.index("refilling: little powder is left")
    assert typist.said[waits + 1 : waits + 3] == ["ready", "printing"]


def test_a_job_that_is_too_fast_for_the_drives_is_rejected(tmp_path: Path) -> None:
    found = bench()
    fast = RING.model_copy(update={"motion": Motion(print_speed=0.5, travel_speed=0.5, acceleration=0.5)})
    with pytest.raises(InputError, match="the job is too fast for the drives"):
        printed(found, tmp_path, Typist({}), job=fast)
    assert not (tmp_path / "run").exists()


def test_a_job_that_is_too_heavy_for_the_drives_is_rejected(tmp_path: Path) -> None:
    found = bench()
    weak = found.twin.owner.winch.model_copy(update={"max_torque": 15.0})
    found.twin = found.twin.with_owner(winch=weak)
    with pytest.raises(InputError, match=r"too heavy for the drives: line .* N m of its drum; its drive has 15"):
        printed(found, tmp_path, Typist({}))
    assert not (tmp_path / "run").exists()


class Held:
    """A button that is held for some steps, then let go; all ends later."""

    def __init__(self, steps: int, tail: int = 150) -> None:
        self.left, self.tail = steps, tail

    def held(self) -> bool:
        self.left -= 1
        return self.left > 0

    def ended(self) -> bool:
        return self.left < -self.tail


def test_a_winch_turns_while_it_is_held_and_its_line_pulls_no_more_than_allowed(tmp_path: Path) -> None:
    found = bench(jog_tension=450.0)
    before, hand = found.rig.plant.rig.winches.lengths_out(), Held(150)
    names = found.rig.names
    arguments = (found.robot, found.twin.owner, tmp_path / "machine", names[0])
    answer = jog_winch(*arguments, -0.02, hand.held, hand.ended, lambda: found.port)
    assert answer.status == "done", answer.reason
    moved = found.rig.plant.rig.winches.lengths_out() - before
    assert -0.05 < moved[0] < -0.005
    assert np.abs(moved[1:]).max() < 1e-3
    capped = bench()  # 30 N, which the line pulls already
    hand, before = Held(150), capped.rig.plant.rig.winches.lengths_out()
    jog_winch(
        capped.robot, capped.twin.owner, tmp_path / "b", names[0], -0.02, hand.held, hand.ended, lambda: capped.port
    )
    assert np.abs(capped.rig.plant.rig.winches.lengths_out() - before).max() < 1e-3
    with pytest.raises(InputError, match=r"at most 0\.25 is allowed by hand"):
        jog_winch(*arguments, 0.3, hand.held, hand.ended, lambda: found.port)


def test_the_platform_is_jogged_while_it_is_held(tmp_path: Path) -> None:
    found = homed(tmp_path)
    before, hand = found.rig.plant.truth.position, Held(200)
    arguments = (found.robot, found.twin.owner, tmp_path / "machine")
    answer = jog_platform(*arguments, (0.0, 0.05, 0.0), hand.held, hand.ended, lambda: found.port)
    assert answer.status == "done", answer.reason
    moved = found.rig.plant.truth.position - before
    assert 0.03 < moved[1] < 0.12
    assert np.abs(moved[[0, 2]]).max() < 0.02


def test_who_is_there_and_what_they_watch(tmp_path: Path) -> None:
    found = bench()
    found.rig.drives[3].dead = True
    answer = scan(found.robot, found.twin.owner, lambda: found.port)
    assert answer.missing == ("north-west",)
    assert [each.identity.node for each in answer.found] == [1, 2, 3]
    found.rig.drives[3].dead = False
    assert show(found.robot, found.twin.owner, lambda: found.port).different > 50
    home(found.robot, found.twin.owner, tmp_path / "machine", found.rig.plant.truth.position, lambda: found.port)
    left = [value for value in show(found.robot, found.twin.owner, lambda: found.port).values if not value.agrees]
    assert {value.object for value in left} == {"0x1016:1 consumer heartbeat"}  # disarmed at the end


def test_an_open_safety_circuit_stops_and_brakes_all(tmp_path: Path) -> None:
    found, steps = bench(inputs={"chain": 17, "brake": 16}), [0]

    def ends() -> bool:
        steps[0] += 1
        if steps[0] == 60:
            found.rig.drives[2].chain_closed = False
        return False

    state = tmp_path / "machine"
    answer = enable(found.robot, found.twin.owner, state, 10.0, lambda: found.port, ends)
    assert answer.reason == "the emergency-stop chain is open"
    assert steps[0] < 200
    assert all(drive.brake_closed for drive in found.rig.drives)
    again = enable(found.robot, found.twin.owner, state, 0.1, lambda: found.port)
    assert again.reason == "reset: the emergency-stop chain is open"
    found.rig.drives[2].chain_closed = True
    assert enable(found.robot, found.twin.owner, state, 0.1, lambda: found.port).status == "done"


def test_a_drum_that_runs_empty_is_no_reason_to_doubt_the_place(tmp_path: Path) -> None:
    found = bench(valve={"line": "north-east", "bit": 17, "closes_alone": True}, flow=4.8)
    place, state = found.rig.plant.truth.position, tmp_path / "machine"
    assert home(found.robot, found.twin.owner, state, place, lambda: found.port).status == "done"
    typist = Typist({name: list(words) for name, words in WORDS.items()}, 10_000)
    assert printed(found, tmp_path, typist, job=SMALL).finished, typist.said
    assert found.rig.plant.truth.powder < 8.0  # of 60 kg lost: more than the 15 % by which what lines carry may be off
