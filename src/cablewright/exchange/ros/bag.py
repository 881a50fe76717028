"""Export of a machine's log as a ROS 2 bag by the library rosbags (the extra ``ros``), without ROS itself.

A bag is a folder: one MCAP file of messages in CDR with the definitions of their types, and ``metadata.yaml``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.ros.fields import filled
from cablewright.exchange.ros.messages import LEFT_OUT, RosMessages
from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.file_output import whole_folder
from cablewright.foundation.progress import Progress, silent
from cablewright.machine.log.log import read_log
from cablewright.robot import Robot

_VERSION: Final = 9  # of the metadata: ROS 2 Jazzy


@dataclass(frozen=True)
class RosBag:
    """Contents of a written bag: messages by topic; ``lost``: sentences on data of the log that it lacks."""

    messages: Mapping[str, int]
    lost: tuple[str, ...]


def ros_bag(robot: Robot, log: Path, out: Path, progress: Progress = silent) -> RosBag:
    """Write the bag *out* of a *log* of *robot*, a file or a run folder, as far as it can be read.

    Raises `InputError` for a log of another robot or none, `EnvironmentFault` without rosbags or where nothing can be
    written.
    """
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise EnvironmentFault("bags of ROS 2 need rosbags: pip install 'cablewright[ros]'") from None
    store, counts = get_typestore(Stores.ROS2_JAZZY), dict[str, int]()
    with read_log(log) as given:
        if given.head.robot.name != robot.name:
            raise InputError(f"{log}: this log belongs to robot {given.head.robot.name!r}, not to {robot.name!r}")
        messages = RosMessages(given.head)
        with whole_folder(out) as folder:
            inner = folder / out.name
            with Writer(inner, version=_VERSION, storage_plugin=StoragePlugin.MCAP) as bag:
                channels: dict[str, Any] = {}
                for step, entry in enumerate(given.entries()):
                    for topic, kind, time, fields in messages.of(entry):
                        if topic not in channels:
                            channels[topic] = bag.add_connection(topic, kind, typestore=store)
                        message = filled(store.types, store, kind, fields)
                        bag.write(channels[topic], time, store.serialize_cdr(message, kind))
                        counts[topic] = counts.get(topic, 0) + 1
                    if step % 500 == 0:
                        progress("writing the bag (bytes of the log)", given.position, given.size)
            if not counts:
                raise InputError(f"{log}: the log has no complete step")
            for each in list(inner.iterdir()):
                each.rename(folder / each.name)
            inner.rmdir()
        return RosBag(counts, (*LEFT_OUT, *given.notes))
