"""The live state for ROS 2: what a second participant reads, and that it is laid out as ROS lays out the types."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("starlette")

os.environ.setdefault(
    "CYCLONEDDS_URI",
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='true'/></Interfaces></General>"
    "</Domain></CycloneDDS>",
)  # before the library is loaded: nothing leaves this computer

import numpy as np
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from rosbags.typesys import Stores, get_typestore

from cablewright.apps.serve.ros_state import RosState
from cablewright.exchange.ros.dds import DdsWriter, require_domain
from cablewright.exchange.ros.fields import filled
from cablewright.exchange.ros.messages import RosMessage, RosMessages
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Estimate, Scan, Tensions
from cablewright.machine.log.log import Entry, read_log
from cablewright.machine.log.messages import encode
from served import served

LOOP = Path(__file__).parents[3] / "examples" / "merlet2023-loop.mcap"
DOMAIN = 71
STORE = get_typestore(Stores.ROS2_JAZZY)
TENSIONS = np.arange(8.0) + 0.5


def topics(head: Any, signals: list[Any]) -> bytes:
    """The topics of *signals*, as the control writes them."""
    made = []
    for signal in signals:
        topic, data = encode(signal, head.robot.winch_names, head.settings.winch.counts, head.epoch_ns)
        made.append(b'["%s",%d,%s]' % (topic.encode(), round(signal.time * 1e9), data))
    return b"[" + b",".join(made) + b"]"


def live(entry: Entry, head: Any, **state: Any) -> Any:
    """A feed at one step of a log, as `Feed` has it after a message of the control."""
    assert entry.estimate is not None
    cells = Tensions("load_cells", entry.estimate.time, TENSIONS[: head.robot.m])
    signals = [cells, entry.estimate, *entry.frame.readings]
    told = {"state": "printing", "clock": time.monotonic(), "layer": 3} | state
    sitting = {"machine": "shed", "robot": head.robot.name}
    return SimpleNamespace(head=head, sitting=sitting, state=told, topics=topics(head, signals))


@pytest.fixture(scope="module")
def loop() -> tuple[Any, Entry]:
    """A log's head, and one of its steps with readings of lidars, whose truth is taken for an estimate."""
    with read_log(LOOP) as log:
        entry = next(each for each in log.entries() if any(isinstance(one, Scan) for one in each.frame.readings))
        truth = entry.truth
        lines = np.zeros(log.head.robot.m)
        told = (truth.time, truth.position, truth.velocity, np.zeros(3), truth.lengths, lines, lines > 1, lines)
        return log.head, replace(entry, estimate=Estimate(*told))


@pytest.fixture(scope="module")
def writer() -> DdsWriter:
    return DdsWriter(DOMAIN)


def sent(feed: Any) -> dict[str, list[RosMessage]]:
    found: dict[str, list[RosMessage]] = {}
    RosState(feed, lambda message: found.setdefault(message.topic, []).append(message)).step()
    return found


def test_the_latest_state_has_ros_names_and_the_logs_numbers(loop: tuple[Any, Entry]) -> None:
    head, entry = loop
    found = sent(live(entry, head))
    assert {"/joint_states", "/tf", "/estimate", "/diagnostics", "/tensions/load_cells"} <= found.keys()
    joints = found["/joint_states"][0].fields
    assert joints["name"] == [line.name for line in head.robot.lines]
    assert np.array_equal(joints["position"], entry.estimate.lengths)
    assert np.array_equal(joints["effort"], TENSIONS[: head.robot.m])
    (drum,) = [each for each in found["/tf"][0].fields["transforms"] if each["child_frame_id"] == "drum"]
    assert list(drum["transform"]["translation"].values()) == list(entry.estimate.position)


def test_efforts_are_of_the_last_half_second(loop: tuple[Any, Entry]) -> None:
    head, entry = loop
    feed, efforts = live(entry, head), list[Any]()
    state = RosState(
        feed, lambda message: efforts.append(message.fields.get("effort")) if message.topic == "/joint_states" else None
    )
    state.step()
    for later, sources in ((0.4, ()), (0.6, ()), (0.7, ("motor_torques",))):
        now = replace(entry.estimate, time=entry.estimate.time + later)
        torques = [Tensions(source, now.time, 2.0 * TENSIONS[: head.robot.m]) for source in sources]
        feed.topics = topics(head, [*torques, now])
        state.step()
    full, same, none, other = efforts
    assert np.array_equal(full, TENSIONS[: head.robot.m])
    assert np.array_equal(same, full)
    assert none is None
    assert np.array_equal(other, 2.0 * full)


def test_what_has_not_changed_is_not_sent_again(loop: tuple[Any, Entry]) -> None:
    head, entry = loop
    feed, names = live(entry, head), list[str]()
    state = RosState(feed, lambda message: names.append(message.topic))
    state.step()
    names.clear()
    state.step()
    assert names == []
    feed.state |= {"state": "paused"}
    state.step()
    assert names == ["/diagnostics"]


@pytest.mark.parametrize(
    ("state", "level", "message"),
    [
        ({}, 0, "printing"),
        ({"faults": ["winch 2: it is slow"]}, 1, "printing"),
        ({"state": "fault", "reason": "a line is slack"}, 2, "fault: a line is slack"),
        ({"state": "fault", "fresh": True}, 0, "fault"),
        ({"clock": -1e9}, 3, "printing"),
        ({"state": "closed", "opening": False, "reason": "the bus is silent"}, 2, "closed: the bus is silent"),
        ({"state": "closed", "opening": True, "reason": "it is being opened"}, 0, "closed: it is being opened"),
        ({"state": "stopped", "reason": "stop"}, 1, "stopped: stop"),
        ({"state": "paused", "reason": "the estimate is late"}, 1, "paused: the estimate is late"),
        ({"state": "paused"}, 0, "paused"),
    ],
)
def test_the_status_is_as_grave_as_the_machine(
    loop: tuple[Any, Entry], state: dict[str, Any], level: int, message: str
) -> None:
    (status,) = sent(live(loop[1], loop[0], **state))["/diagnostics"][0].fields["status"]
    assert (status["level"], status["message"], status["name"]) == (level, message, "cablewright: shed")


def test_all_types_are_laid_out_as_in_ros(loop: tuple[Any, Entry], writer: DdsWriter) -> None:
    head, entry = loop
    messages = [*(each for own in sent(live(entry, head)).values() for each in own), *RosMessages(head).of(entry)]
    kinds = set()
    for message in messages:
        writer.write(message)
        made = filled(writer.classes, STORE, message.type, message.fields, lists=True)
        expected = STORE.serialize_cdr(filled(STORE.types, STORE, message.type, message.fields), message.type)
        assert bytes(made.serialize(use_version_2=False)) == bytes(expected), message.topic
        package, _, name = message.type.split("/")
        assert made.__idl_typename__.replace(".", "::") == f"{package}::msg::dds_::{name}_"
        kinds.add(message.type)
    assert len(kinds) >= 6


def reader(topic: str, kind: Any) -> DataReader:
    """As a subscription of ROS 2 for readings of sensors."""
    participant = DomainParticipant(DOMAIN)
    qos = Qos(Policy.Reliability.BestEffort, Policy.DataRepresentation(use_cdrv0_representation=True))
    return DataReader(participant, Topic(participant, topic, kind), qos=qos)


def test_a_second_participant_reads_it(loop: tuple[Any, Entry], writer: DdsWriter) -> None:
    head, entry = loop
    (message,) = sent(live(entry, head))["/joint_states"]
    writer.write(message)  # its class is made
    reading = reader("rt/joint_states", writer.classes[message.type])
    found: list[Any] = []
    end = time.monotonic() + 20.0
    while not found and time.monotonic() < end:
        writer.write(message)
        time.sleep(0.05)
        found = reading.take(10)
    assert found[0].name == message.fields["name"]
    assert found[0].position == message.fields["position"].tolist()


@pytest.mark.parametrize("domain", [-1, 233])
def test_a_number_of_no_domain_is_rejected(domain: int) -> None:
    with pytest.raises(InputError, match="a domain from 0 to 232 is expected"):
        require_domain(domain)


@pytest.fixture
def states() -> DataReader:
    maker = DdsWriter(DOMAIN + 1)
    message = RosMessage("/joint_states", "sensor_msgs/msg/JointState", 0, {})
    maker.write(message)
    participant = DomainParticipant(DOMAIN + 1)
    return DataReader(participant, Topic(participant, "rt/joint_states", maker.classes[message.type]))


@pytest.mark.slow
@pytest.mark.clock
def test_a_served_machine_is_read_at_ten_hertz(states: DataReader, tmp_path: Path) -> None:
    with served(tmp_path / "out", "house-printer", "--ros2", str(DOMAIN + 1)):
        end, stamps = time.monotonic() + 30.0, list[float]()
        while len(stamps) < 40 and time.monotonic() < end:
            stamps += [each.header.stamp.sec + 1e-9 * each.header.stamp.nanosec for each in states.take(100)]
            time.sleep(0.05)
    assert len(stamps) >= 40
    assert all(later > earlier for earlier, later in pairwise(stamps))
    assert (len(stamps) - 1) / (stamps[-1] - stamps[0]) >= 10.0
