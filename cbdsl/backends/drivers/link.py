"""Links: open connections of one kind to the parts of a robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any, NamedTuple, Protocol, runtime_checkable

from cbdsl.backends.backend import BackendError
from cbdsl.backends.drivers.sample import Command, Sample
from cbdsl.backends.engines import extra_advice
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.driver import Driver
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.robot.driver_kind import DRIVERS


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


def open_links(robot: RobotDocument, interface: str | None) -> list[DriverLink]:
    """Open all drivers of a robot, one link for each kind.

    Args:
        robot: Robot with drivers.
        interface: Network interface; loopback only if ``None``.

    Raises:
        BackendError: The robot has no drivers, a kind is unknown or not installed, or a link cannot
            be opened.
    """
    by_kind: dict[str, dict[str, Driver]] = {}
    for name, driver in robot.drivers.items():
        by_kind.setdefault(driver.kind, {})[name] = driver
    links: list[DriverLink] = []
    try:
        links.extend(_factory(kind)(robot, own, interface) for kind, own in by_kind.items())
    # Also at Ctrl-C: an open link would keep its bus or its network participant.
    except BaseException:
        for link in links:
            link.close()
        raise
    return links


def require_drivers(robot: RobotDocument) -> None:
    """Refuse a robot without drivers.

    Raises:
        BackendError: It has none.
    """
    if not robot.drivers:
        raise BackendError(
            f"robot '{robot.name}' has no drivers; its document declares them below 'drivers'"
        )


def _factory(kind: str) -> DriverLinkFactory:
    try:
        module, _, attribute = DRIVERS.get(kind).link.partition(":")
        factory: DriverLinkFactory = getattr(import_module(module), attribute)
    except ImportError as error:
        raise BackendError(
            f"driver kind '{kind}' cannot be loaded: {error}; {extra_advice(kind)}"
        ) from error
    except UsageError as error:
        raise BackendError(str(error)) from error
    return factory
