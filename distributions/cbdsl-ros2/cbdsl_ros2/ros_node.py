"""Node: participant of a ROS 2 domain, its topics, and its view of the others."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from functools import cached_property
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsParticipant,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.core import DDSException, InstanceState, ReadCondition, SampleState, ViewState
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from cbdsl.extend.driver import BackendError, absolute

LOOPBACK = "lo"
# Lease of a participant's liveliness, s: others see its death after it.
_LEASE = 0.5
_QUEUED = 10
_BLOCKING = 0.0
_MOST_ENDPOINTS = 4096
# Properties by which participants of Cyclone and of Fast DDS name their process.
_PROCESS = ("__Pid", "fastdds.physical_data.process")

# Loopback has no multicast: participants of this computer are found by their ports. A participant
# that begins may miss the first announcement, and announces its own endpoints by the next one.
_LOCAL = """
<CycloneDDS><Domain Id="any">
  <General>
    <Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
    <AllowMulticast>false</AllowMulticast>
    <MaxMessageSize>65500B</MaxMessageSize>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex>
    <MaxAutoParticipantIndex>60</MaxAutoParticipantIndex>
    <LeaseDuration>3s</LeaseDuration>
    <SPDPInterval>50ms</SPDPInterval>
    <Peers><Peer address="127.0.0.1"/></Peers>
  </Discovery>
</Domain></CycloneDDS>"""
_NAMED = """
<CycloneDDS><Domain Id="any">
  <General><Interfaces><NetworkInterface name="{name}"/></Interfaces></General>
  <Discovery><SPDPInterval>50ms</SPDPInterval></Discovery>
</Domain></CycloneDDS>"""

# Domains that a node of this process uses, by number.
_DOMAINS: WeakValueDictionary[int, _Domain] = WeakValueDictionary()


class Remote(NamedTuple):
    """Reader or writer of a topic, anywhere in the domain.

    Attributes:
        key: Identifier.
        topic: Topic of ROS.
        type: Message type by its DDS name.
        writes: True for a writer.
        participant: Identifier of its participant.
        handle: Number of its messages' publisher in this process.
        qos: Quality of service.
    """

    key: Any
    topic: str
    type: str
    writes: bool
    participant: Any
    handle: int
    qos: Qos


class RosNode:
    """Participant of a domain.

    Args:
        interface: Network interface; loopback only if ``None``.

    Raises:
        BackendError: There is no such interface, the configuration is faulty, or the domain has
            no free port.
    """

    def __init__(self, interface: str | None = None) -> None:
        self._domain = _domain(domain_id(), interface or LOOPBACK)
        try:
            self._participant = DomainParticipant(self._domain.number)
        except DDSException:
            raise BackendError(_refusal(self._domain.number, self._domain.interface)) from None
        self._lease = Policy.Liveliness.Automatic(duration(seconds=_LEASE))

    @cached_property
    def _endpoints(self) -> list[_Endpoints]:
        """Readers of the domain's writers and readers, made when they are first needed."""
        return [
            _Endpoints(self._participant, BuiltinTopicDcpsPublication, writes=True),
            _Endpoints(self._participant, BuiltinTopicDcpsSubscription, writes=False),
        ]

    @property
    def has_news(self) -> bool:
        """True if readers or writers came or went since the last call of ``remotes``."""
        return any(endpoints.has_news for endpoints in self._endpoints)

    def reader(
        self,
        topic: str,
        message: type[Any],
        *,
        lasting: bool = False,
        reliable: bool = False,
        every: bool = False,
    ) -> DataReader[Any]:
        """Return a reader of a topic.

        Args:
            topic: Topic of ROS.
            message: Message type.
            lasting: True if the newest message before the reader's time is read, too.
            reliable: True if lost messages are sent again; such a reader does not match writers
                that do not offer it.
            every: True if all messages are kept until they are taken. Otherwise those of one
                writer may replace the last one of another.
        """
        qos = _qos(lasting or reliable, lasting)
        if every:
            qos = Qos(Policy.History.KeepAll, base=qos)
        return DataReader(self._participant, self._topic(topic, message), qos)

    def writer(
        self,
        topic: str,
        message: type[Any],
        *,
        lasting: bool = False,
        reliable: bool = True,
        deadline: float | None = None,
    ) -> DataWriter[Any]:
        """Return a writer of a topic.

        Args:
            topic: Topic of ROS.
            message: Message type.
            lasting: True if later readers get the newest message, too.
            reliable: True if lost messages are sent again.
            deadline: Longest time between two messages that is offered, s; readers may ask for it.
        """
        policies = [] if deadline is None else [Policy.Deadline(duration(seconds=deadline))]
        qos = _qos(reliable, lasting, self._lease, *policies)
        return DataWriter(self._participant, self._topic(topic, message), qos)

    def _topic(self, topic: str, message: type[Any]) -> Topic[Any]:
        # ROS 2 puts the prefix ``rt`` before its topics in DDS.
        return Topic(self._participant, f"rt{absolute(topic)}", message)

    def process(self, remote: Remote) -> str:
        """Return the process of a remote reader or writer, such as "process 4711"."""
        reader = BuiltinDataReader(self._participant, BuiltinTopicDcpsParticipant)
        for participant in reader.read(_MOST_ENDPOINTS):
            if participant.key == remote.participant:
                for policy in participant.qos:
                    if isinstance(policy, Policy.Property) and policy.key in _PROCESS:
                        return f"process {policy.value}"
        return "an unknown process"

    def remotes(self) -> list[Remote]:
        """Return all living readers and writers of ROS topics in the domain."""
        return [remote for endpoints in self._endpoints for remote in endpoints.living()]

    def close(self) -> None:
        """Leave the domain."""
        self.__dict__.pop("_endpoints", None)
        del self._participant, self._domain


class _Endpoints:
    """Readers or writers of all participants in a domain.

    Args:
        participant: Participant that watches them.
        topic: Built-in topic that announces them.
        writes: True if they are writers.
    """

    def __init__(self, participant: DomainParticipant, topic: Any, *, writes: bool) -> None:
        self._reader, self._writes = BuiltinDataReader(participant, topic), writes
        any_sample = ViewState.Any | SampleState.Any
        gone = InstanceState.NotAliveDisposed | InstanceState.NotAliveNoWriters
        self._alive = ReadCondition(self._reader, any_sample | InstanceState.Alive)
        self._gone = ReadCondition(self._reader, any_sample | gone)
        unread = ViewState.Any | SampleState.NotRead | InstanceState.Any
        self._news = ReadCondition(self._reader, unread)

    @property
    def has_news(self) -> bool:
        """True if one came or went since the last call of ``living``."""
        return bool(self._news.is_triggered())

    def living(self) -> Iterator[Remote]:
        """Yield the living endpoints of ROS topics, and forget the others."""
        # Without this, endpoints that have ended would stay in memory.
        self._reader.take(_MOST_ENDPOINTS, self._gone)
        # Reading leaves no news.
        for endpoint in self._reader.read(_MOST_ENDPOINTS, self._alive):
            # Topics, and requests of services, of which actions consist.
            if endpoint.topic_name.startswith(("rt/", "rq/")):
                topic = endpoint.topic_name[2:]
                yield Remote(
                    endpoint.key, topic, endpoint.type_name, self._writes,
                    endpoint.participant_key, endpoint.sample_info.instance_handle, endpoint.qos,
                )  # fmt: skip


class _Domain:
    """Domain with the configuration of an interface; of one, there is one in a process."""

    def __init__(self, number: int, interface: str) -> None:
        self.number, self.interface = number, interface
        _require_interface(interface)
        try:
            self._domain = Domain(number, configuration(interface))
        except DDSException:
            raise BackendError(_refusal(number, interface)) from None


def _refusal(number: int, interface: str) -> str:
    """Return the reason why DDS opens no domain, as a sentence without a full stop."""
    given = os.environ.get("CYCLONEDDS_URI")
    if given:
        return (
            f"DDS cannot be configured by CYCLONEDDS_URI, which is '{given}'; its own lines above "
            "have the cause"
        )
    return (
        f"DDS cannot open domain {number} at the network interface '{interface}'; its own line "
        "above has the cause, such as too many programs in the domain: ROS_DOMAIN_ID chooses "
        "another"
    )


def _require_interface(interface: str) -> None:
    """Refuse a network interface that this computer does not have.

    Raises:
        BackendError: There is none of this name.
    """
    known = [name for _, name in socket.if_nameindex()]
    if interface not in known:
        raise BackendError.unknown("network interface", interface, known)


def _domain(number: int, interface: str) -> _Domain:
    """Return the process's domain of a number.

    Raises:
        BackendError: It uses another interface, or cannot use this one.
    """
    domain = _DOMAINS.get(number)
    if domain is None:
        domain = _DOMAINS[number] = _Domain(number, interface)
    if domain.interface != interface:
        raise BackendError(
            f"this process uses the network interface '{domain.interface}' for domain {number}, "
            f"and cannot use '{interface}' as well"
        )
    return domain


def domain_id() -> int:
    """Return the number of the domain, from ``ROS_DOMAIN_ID`` as in ROS.

    Raises:
        BackendError: It is not a number from 0 to 232.
    """
    text = os.environ.get("ROS_DOMAIN_ID") or "0"
    if not (text.isascii() and text.isdecimal() and len(text) <= 3 and int(text) <= 232):
        raise BackendError(f"ROS_DOMAIN_ID is '{text}'; it has to be a number from 0 to 232")
    return int(text)


def configuration(interface: str) -> str:
    """Return Cyclone's configuration: that of ``CYCLONEDDS_URI``, and the network interface."""
    own = _LOCAL if interface == LOOPBACK else _NAMED.format(name=interface)
    given = os.environ.get("CYCLONEDDS_URI")
    return f"{given},{own}" if given else own


def _qos(reliable: bool, lasting: bool, *policies: Any) -> Qos:
    """Return the quality of service as ROS names it: keep last, reliable, transient local."""
    blocking = duration(seconds=_BLOCKING)
    return Qos(
        Policy.Reliability.Reliable(blocking) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if lasting else Policy.Durability.Volatile,
        Policy.History.KeepLast(1 if lasting else _QUEUED),
        *policies,
    )
