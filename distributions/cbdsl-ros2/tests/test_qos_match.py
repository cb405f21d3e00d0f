"""Match of qualities of service, as DDS itself decides it."""

from __future__ import annotations

import time
from typing import Any

import pytest

pytest.importorskip("cyclonedds")

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from cbdsl_ros2 import dds_types as msg
from cbdsl_ros2.qos_match import mismatch
from cbdsl_ros2.ros_node import RosNode

SHORT, LONG = duration(milliseconds=10), duration(seconds=1)
RELIABLE = Policy.Reliability.Reliable(0)
POLICIES: dict[str, tuple[Any, ...]] = {
    "reliability": (Policy.Reliability.BestEffort, RELIABLE),
    "durability": (Policy.Durability.Volatile, Policy.Durability.TransientLocal),
    "deadline": (Policy.Deadline(SHORT), Policy.Deadline(LONG)),
    "budget": (Policy.LatencyBudget(SHORT), Policy.LatencyBudget(LONG)),
    "liveliness": (Policy.Liveliness.Automatic(LONG), Policy.Liveliness.ManualByTopic(LONG)),
    "lease": (Policy.Liveliness.Automatic(SHORT), Policy.Liveliness.Automatic(LONG)),
    "order": (
        Policy.DestinationOrder.ByReceptionTimestamp,
        Policy.DestinationOrder.BySourceTimestamp,
    ),
    "ownership": (Policy.Ownership.Shared, Policy.Ownership.Exclusive),
}


@pytest.mark.parametrize("name", POLICIES)
def test_mismatch_agrees_with_dds(name: str, node: RosNode) -> None:
    participant = DomainParticipant(node._domain.number)
    pairs = [(a, b) for a in POLICIES[name] for b in POLICIES[name]]
    for index, (offered, requested) in enumerate(pairs):
        topic = Topic(participant, f"rt/{name}_{index}", msg.Flag)
        base = Qos() if name == "reliability" else Qos(RELIABLE)
        writer = DataWriter(participant, topic, Qos(offered, base=base))
        reader = DataReader(participant, topic, Qos(requested, base=base))
        time.sleep(0.01)
        is_matched = bool(reader.get_matched_publications())
        clause = mismatch(writer.get_qos(), reader.get_qos())
        assert (clause == "") is is_matched, (offered, requested, clause)


def test_mismatch_of_partitions_is_found() -> None:
    apart, wild = Qos(Policy.Partition(["cell"])), Qos(Policy.Partition(["c*"]))
    assert mismatch(apart, Qos()) == "is in the partition 'cell'"
    assert mismatch(apart, wild) == ""
