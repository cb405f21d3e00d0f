"""Driver of a robot whose joints are at their references, in this process."""

import time
from collections.abc import Iterator, Mapping, Sequence

from cbdsl.extend.driver import (
    Command,
    Driver,
    DriverKind,
    Endpoint,
    JointSample,
    Problem,
    RobotDocument,
    Sample,
)


def problems(driver: Driver) -> Iterator[Problem]:
    """Return whether the addresses are words after ``echo:``."""
    if driver.states is not None and not driver.states.startswith("echo:"):
        yield ("states",), f"'{driver.states}' does not begin with 'echo:'"


class EchoLink:
    """Link to a robot whose joints are at their references."""

    def __init__(
        self, robot: RobotDocument, drivers: Mapping[str, Driver], interface: str | None
    ) -> None:
        self._positions: dict[str, Command] = {}
        self._count = 0
        for name, driver in drivers.items():
            joints = tuple(j for effector in driver.moves for j in robot.joints(effector))
            starts = [
                position
                for member in driver.moves
                for effector in [robot.effectors[member]]
                for position in effector.postures[effector.start or ""]
            ]
            self._positions[name] = Command(joints, tuple(starts), 0.0, 0.0)

    def poll(self) -> Sequence[Sample]:
        """Return the references as joint states, with noise in the last digit."""
        self._count += 1
        noise, now = 1e-9 * (self._count % 7), time.time()
        return [
            JointSample(
                name,
                now,
                command.names,
                tuple(position + noise for position in command.positions),
                velocities=(0.0,) * len(command.names),
            )
            for name, command in self._positions.items()
        ]

    def claim(self) -> None:
        """Do nothing: no other program commands it."""

    def send(self, driver: str, command: Command) -> None:
        """Move to references."""
        self._positions[driver] = command

    def rest(self) -> None:
        """Do nothing: the robot stands at its references."""

    def survey(self) -> Sequence[Endpoint]:
        """Return no streams: there is no network."""
        return ()

    def close(self) -> None:
        """Release nothing, because nothing was opened."""


ECHO = DriverKind("echo", "a robot in this process", problems, "demo.echo:EchoLink")
