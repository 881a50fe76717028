"""Messages of ROS 2 over DDS, by Eclipse Cyclone DDS (the extra ``ros2``); ROS itself is not needed.

The topic ``/x`` is ``rt/x`` in DDS and the type ``p/msg/T`` is ``p::msg::dds_::T_``, as the middleware of ROS 2 names
them (design.ros2.org, "Topic and Service name mapping to DDS").
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any, Final

from cablewright.exchange.ros.fields import filled
from cablewright.exchange.ros.messages import RosMessage
from cablewright.foundation.errors import EnvironmentFault, InputError

DOMAINS: Final = range(233)
"""Numbers of domains: each has ports of its own, below 65536."""

_KEPT: Final = 10  # messages for a reader that is behind, as in ROS 2
_WAIT: Final = 5e-3  # s, the longest that a reader which is behind holds a message up; then it is dropped


def require_domain(domain: int) -> None:
    """Raise `InputError` for an invalid number of a domain, `EnvironmentFault` without the extra."""
    if domain not in DOMAINS:
        raise InputError(f"--ros2 = {domain}: a domain from {DOMAINS[0]} to {DOMAINS[-1]} is expected")
    if missing := [name for name in ("cyclonedds", "rosbags") if find_spec(name) is None]:
        raise EnvironmentFault(f"ROS 2: {missing[0]} is not installed: pip install 'cablewright[ros2]'")


class DdsWriter:
    """Publisher of ROS 2 messages in a DDS domain; reads nothing."""

    def __init__(self, domain: int) -> None:
        """Join a *domain*. Raises as `require_domain`, and `EnvironmentFault` where the network rejects it."""
        require_domain(domain)
        from cyclonedds.core import DDSException, Policy, Qos
        from cyclonedds.domain import DomainParticipant
        from cyclonedds.util import duration
        from rosbags.typesys import Stores, get_typestore

        try:
            self._participant = DomainParticipant(domain)
        except DDSException as reason:
            raise EnvironmentFault(f"domain {domain} of ROS 2 cannot be joined: {reason.msg}") from None
        self._qos = Qos(
            Policy.Reliability.Reliable(duration(seconds=_WAIT)),
            Policy.Durability.Volatile,
            Policy.History.KeepLast(_KEPT),
            Policy.DataRepresentation(use_cdrv0_representation=True),
        )
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._writers: dict[str, Any] = {}
        self.classes: dict[str, Any] = {}

    def write(self, message: RosMessage) -> None:
        """Publish one message; a reader that has no room for it loses it."""
        from cyclonedds.core import DDSException

        if message.topic not in self._writers:
            self._writers[message.topic] = self._writer(message.topic, self._class(message.type))
        made = filled(self.classes, self._store, message.type, message.fields, lists=True)
        try:
            self._writers[message.topic].write(made)
        except DDSException as reason:
            if reason.code != DDSException.DDS_RETCODE_TIMEOUT:
                raise EnvironmentFault(f"ROS 2: {message.topic} cannot be written: {reason.msg}") from None

    def _writer(self, topic: str, kind: Any) -> Any:
        from cyclonedds.pub import DataWriter
        from cyclonedds.topic import Topic

        named = Topic(self._participant, f"rt{topic}", kind, qos=self._qos)
        return DataWriter(self._participant, named, qos=self._qos)

    def _class(self, kind: str) -> Any:
        """The class of a type of messages, with those of its fields."""
        if kind not in self.classes:
            from cyclonedds.idl import make_idl_struct

            package, _, name = kind.split("/")
            fields = {field: self._field(told) for field, told in self._store.fielddefs[kind][1]}
            self.classes[kind] = make_idl_struct(f"{name}_", f"{package}::msg::dds_::{name}_", fields)
        return self.classes[kind]

    def _field(self, told: Any) -> Any:
        from cyclonedds.idl import types

        node, of = told
        if node.name == "NAME":
            return self._class(of)
        if node.name == "BASE":
            return {"string": str, "bool": bool}.get(of[0]) or getattr(types, of[0])
        element, count = of
        kind = self._field(element)
        return types.array[kind, count] if node.name == "ARRAY" else types.sequence[kind]
