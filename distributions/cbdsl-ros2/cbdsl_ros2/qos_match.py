"""Match of a writer's offered with a reader's requested quality of service, as DDS defines it."""

from __future__ import annotations

from collections.abc import Iterator
from fnmatch import fnmatchcase
from typing import Any

from cyclonedds.qos import Policy, Qos
from cyclonedds.util import duration

# Kinds of policies, weakest first: a reader matches writers that offer its kind or a stronger one.
_RANKED: tuple[tuple[Any, dict[str, str]], ...] = (
    (Policy.Reliability, {"BestEffort": "best effort", "Reliable": "reliable"}),
    (
        Policy.Durability,
        {
            "Volatile": "volatile",
            "TransientLocal": "transient local",
            "Transient": "transient",
            "Persistent": "persistent",
        },
    ),
    (
        Policy.Liveliness,
        {
            "Automatic": "alive by its process",
            "ManualByParticipant": "alive by its participant",
            "ManualByTopic": "alive by its messages",
        },
    ),
    (
        Policy.DestinationOrder,
        {"ByReceptionTimestamp": "ordered by reception", "BySourceTimestamp": "ordered by source"},
    ),
)
# Times that a writer offers at most as long as a reader requests them.
_TIMES = (
    (Policy.Deadline, "deadline", "deadline"),
    (Policy.LatencyBudget, "budget", "latency budget"),
    (Policy.Liveliness, "lease_duration", "lease"),
)
_FOREVER = duration(infinite=True)


def mismatch(offered: Qos, requested: Qos) -> str:
    """Return the policies by which a reader gets no message of a writer, as a clause.

    Args:
        offered: Quality of service of the writer.
        requested: Quality of service of the reader.

    Returns:
        A clause such as "is best effort, and has to be reliable"; empty if they match.
    """
    return "; ".join(_mismatches(offered, requested))


def _mismatches(offered: Qos, requested: Qos) -> Iterator[str]:
    for policy, names in _RANKED:
        given, needed = (_rank(qos, policy, names) for qos in (offered, requested))
        if given < needed:
            words = list(names.values())
            yield f"is {words[given]}, and has to be {words[needed]}"
    for policy, key, name in _TIMES:
        given, needed = (getattr(qos[policy], key, 0) for qos in (offered, requested))
        if given > needed and policy in requested:
            yield f"has a {name} of {_seconds(given)}, and at most {_seconds(needed)} are needed"
    if (Policy.Ownership.Exclusive in offered) != (Policy.Ownership.Exclusive in requested):
        yield "has another ownership"
    ours, theirs = (getattr(q[Policy.Partition], "partitions", ("",)) for q in (requested, offered))
    if not any(fnmatchcase(a, b) or fnmatchcase(b, a) for a in ours for b in theirs):
        yield f"is in the partition {', '.join(map(repr, theirs))}"


def _rank(qos: Qos, policy: Any, names: dict[str, str]) -> int:
    kind = type(qos[policy]).__name__.rpartition(".")[2]
    return list(names).index(kind) if kind in names else 0


def _seconds(nanoseconds: int) -> str:
    return "infinity" if nanoseconds >= _FOREVER else f"{1e-9 * nanoseconds:g} s"
