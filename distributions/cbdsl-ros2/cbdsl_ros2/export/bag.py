"""MCAP files of ROS 2 messages."""

from __future__ import annotations

import io
from typing import Any

from mcap.writer import Writer

from cbdsl_ros2.export.ros_messages import NANO, TYPES

# Quality of service of topics whose last message late subscribers get, too: keep last 1, reliable,
# transient local, as the recorder of ROS 2 Humble writes it.
_FOREVER = "\n    sec: 2147483647\n    nsec: 4294967295"
_LATCHED = (
    "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n"
    f"  deadline:{_FOREVER}\n  lifespan:{_FOREVER}\n  liveliness: 1\n"
    f"  liveliness_lease_duration:{_FOREVER}\n  avoid_ros_namespace_conventions: false"
)


class Bag:
    """MCAP file in memory that messages are added to in the order of time.

    Attributes:
        count: Number of messages.
    """

    def __init__(self) -> None:
        self._stream = io.BytesIO()
        self._writer = Writer(self._stream)
        self._writer.start(profile="ros2", library="cbdsl")
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self.count = 0

    def put_metadata(self, name: str, values: dict[str, str]) -> None:
        """Add texts under a name."""
        self._writer.add_metadata(name, values)

    def put(self, topic: str, time: float, message: Any, *, latched: bool = False) -> None:
        """Add a message.

        Args:
            topic: Topic.
            time: Time of recording and of publication, s.
            message: Message, as ``make`` gives it.
            latched: True if late subscribers shall get the last message of this topic.
        """
        if topic not in self._channels:
            schema = self._schema(message.__msgtype__)
            quality = {"offered_qos_profiles": _LATCHED if latched else ""}
            self._channels[topic] = self._writer.register_channel(topic, "cdr", schema, quality)
        data = TYPES.serialize_cdr(message, message.__msgtype__)
        moment = round(time * NANO)
        self._writer.add_message(self._channels[topic], moment, bytes(data), moment)
        self.count += 1

    def _schema(self, name: str) -> int:
        if name not in self._schemas:
            text, _ = TYPES.generate_msgdef(name, ros_version=2)
            self._schemas[name] = self._writer.register_schema(name, "ros2msg", text.encode())
        return self._schemas[name]

    def finish(self) -> bytes:
        """Return the contents of the file; no message can be added afterwards."""
        self._writer.finish()
        return self._stream.getvalue()
