"""Links: open connections of one kind to the parts of a robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

from cbdsl.backends.driver_sample import Command, Sample
from cbdsl.documents.driver import Driver
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument


class Endpoint(NamedTuple):
    """A stream of messages that a driver needs, and its state on the network.

    Attributes:
        driver: Name of the driver.
        role: Key of the driver that names the address, such as ``states``.
        address: Address, such as a topic.
        type: Message type that the driver expects.
        outgoing: True if the driver writes it.
        peers: Number of other writers if the driver reads the stream, or of readers if it writes.
        rivals: Processes of other writers if the driver writes the stream.
        refusals: Clauses about writers whose messages never arrive, such as one that is not
            reliable.
        foreign_types: Message types of the others on this address, if they differ.
        candidates: Addresses of other streams with this message type.
        rate: Messages per second that arrived since the link was opened.
        age: Time since the newest message, s; ``None`` without one.
    """

    driver: str
    role: str
    address: str
    type: str
    outgoing: bool
    peers: int
    rivals: tuple[str, ...] = ()
    refusals: tuple[str, ...] = ()
    foreign_types: tuple[str, ...] = ()
    candidates: tuple[str, ...] = ()
    rate: float = 0.0
    age: float | None = None


class DriverLink(Protocol):
    """Open connection to the parts of a robot that drivers of one kind reach."""

    def poll(self) -> Sequence[Sample]:
        """Return the samples that arrived since the last call, oldest first, without waiting."""
        ...

    def claim(self) -> None:
        """Appear as the robot's commander; before the first reference, and maybe repeatedly.

        A link that is not claimed reads only, so that it disturbs no program.
        """
        ...

    def send(self, driver: str, command: Command) -> None:
        """Send references to a driver's controller."""
        ...

    def rest(self) -> None:
        """Say that no references follow until an episode begins anew; maybe repeatedly."""
        ...

    def survey(self) -> Sequence[Endpoint]:
        """Return the state of each stream that the drivers need."""
        ...

    def close(self) -> None:
        """Close the connection."""
        ...


class Setup(NamedTuple):
    """Stage that an episode requires.

    Attributes:
        robot: Name of the robot.
        stage: Stage.
        context: Context of the stage; drawn if ``None``.
        draws: State of the episode's generator before its first draw, as of
            ``numpy.random.BitGenerator.state``.
    """

    robot: str
    stage: StageDocument
    context: str | None
    draws: Mapping[str, Any]


@runtime_checkable
class StagingLink(Protocol):
    """Link to a robot whose peer sets up the stage, such as a simulation."""

    @property
    def stages(self) -> bool:
        """True if the peer sets up stages."""
        ...

    def ask(self, setup: Setup) -> None:
        """Request a stage; repeated requests of one set-up are one."""
        ...

    def answer(self) -> str | None:
        """Return the answer to the newest request: empty, or the reason of a refusal.

        ``None`` without an answer so far.
        """
        ...


DriverLinkFactory = Callable[[RobotDocument, Mapping[str, Driver], str | None], DriverLink]
"""Open drivers of one kind: robot, drivers by name, network interface (loopback if ``None``)."""
