"""Survey: the reasons against a network's streams of messages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from cbdsl.extend.driver import Endpoint
from cbdsl.extend.model import suggestion


class StreamProblem(NamedTuple):
    """Reason against the stream at an address, as a sentence without a full stop."""

    address: str
    text: str


def survey_problems(endpoints: Iterable[Endpoint]) -> Iterator[StreamProblem]:
    """Yield the problem of each stream that cannot carry a driver's messages."""
    for endpoint in endpoints:
        yield from (StreamProblem(endpoint.address, text) for text in _problems(endpoint))


def _problems(endpoint: Endpoint) -> Iterator[str]:
    where = f"{endpoint.address} (driver '{endpoint.driver}', {endpoint.role})"
    if endpoint.foreign_types:
        types = ", ".join(endpoint.foreign_types)
        yield f"{where} has the type {types}, and {endpoint.type} is needed"
    elif not endpoint.peers:
        verb = "listens to" if endpoint.outgoing else "writes to"
        yield f"nothing {verb} {where}{_alternatives(endpoint)}"
    # One publisher of another stream is enough, but each button of an emergency stop counts.
    elif endpoint.role == "stop" or len(endpoint.refusals) == endpoint.peers:
        yield from (f"{refusal} at {where}" for refusal in endpoint.refusals)
    if endpoint.rivals:
        yield f"another commander writes to {where}: {', '.join(endpoint.rivals)}"


def _alternatives(endpoint: Endpoint) -> str:
    """Return streams that may have been intended, as a clause."""
    watchdog = endpoint.outgoing and endpoint.address.endswith("/guarded")
    if watchdog:
        return "; 'cb drive watchdog' has to run"
    if not endpoint.candidates:
        return ""
    near = suggestion(endpoint.address, endpoint.candidates)
    return f"{near} (with type {endpoint.type}: {', '.join(endpoint.candidates)})"
